//! Sweeps: parameters that change from one value to another over the frames.

use super::{
    error::SweepError,
    parameter::{Domain, Parameter},
};
use crate::values;
use glam::Vec3;
use lapidary_render::Look;
use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};

/// A value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// A number.
    Number(f32),
    /// A color, or a position in meters.
    Vector(Vec3),
}

impl Value {
    /// As a number; the first component of a vector.
    pub fn number(self) -> f32 {
        match self {
            Self::Number(number) => number,
            Self::Vector(vector) => vector.x,
        }
    }

    /// As a vector; a number is repeated three times.
    pub fn vector(self) -> Vec3 {
        match self {
            Self::Number(number) => Vec3::splat(number),
            Self::Vector(vector) => vector,
        }
    }
}

impl fmt::Display for Value {
    /// With four digits, for captions.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let short = |number: f32| {
            let digits = (3 - number.abs().max(1e-6).log10().floor() as i32).clamp(0, 6) as usize;
            let text = format!("{number:.digits$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
        };
        match self {
            Self::Number(number) => f.write_str(&short(*number)),
            Self::Vector(v) => write!(f, "{}, {}, {}", short(v.x), short(v.y), short(v.z)),
        }
    }
}

/// A parameter that changes from one value to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The parameter.
    pub parameter: Parameter,
    /// Name of its material or light; without it all, or the only one.
    pub of: Option<String>,
    /// Value of the first frame.
    pub from: Value,
    /// Value of the last frame.
    pub to: Value,
    /// Equal ratios instead of equal steps.
    pub logarithmic: bool,
}

impl FromStr for Sweep {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let form = || SweepError::Form(text.into());
        let (left, right) = text.split_once('=').ok_or_else(form)?;
        let (name, of) = match left.split_once('@') {
            Some((name, of)) => (name, Some(of.to_owned())),
            None => (left, None),
        };
        let parameter = Parameter::all().find(|p| p.name() == name.trim()).ok_or_else(|| {
            let known: Vec<_> = Parameter::all().map(|p| p.name()).collect();
            SweepError::Unknown { name: name.trim().into(), known: known.join(", ") }
        })?;
        let (logarithmic, range) = match right.trim().strip_prefix("log:") {
            Some(range) => (true, range),
            None => (false, right),
        };
        let (from, to) = range.split_once("..").ok_or_else(form)?;
        let (from, to) = (parsed(parameter, from)?, parsed(parameter, to)?);
        let sweep = Self { parameter, of, from, to, logarithmic };
        sweep.check_form()?;
        Ok(sweep)
    }
}

fn parsed(parameter: Parameter, text: &str) -> Result<Value, SweepError> {
    let value = match parameter.domain() {
        Domain::Number(..) => values::finite(text).map(Value::Number),
        Domain::Color => values::color(text).map(Value::Vector),
        Domain::Place => values::place(text).map(Value::Vector),
    };
    value.map_err(|reason| SweepError::Value { parameter: parameter.name(), text: text.trim().into(), reason })
}

impl Sweep {
    /// Name of its values in files and captions.
    pub fn label(&self) -> String {
        let name = self.parameter.name();
        self.of.as_ref().map_or(name.clone(), |of| format!("{name}@{of}"))
    }

    /// Checks ranges, logarithms and the name.
    ///
    /// # Errors
    /// The first problem.
    pub fn check_form(&self) -> Result<(), SweepError> {
        let name = self.parameter.name();
        if self.of.is_some() && self.parameter.target() == super::Target::Picture {
            return Err(SweepError::NoName(name));
        }
        for value in [self.from, self.to] {
            self.check_value(value)?;
        }
        let is_number = matches!(self.parameter.domain(), Domain::Number(..));
        let positive = self.from.number() > 0.0 && self.to.number() > 0.0;
        if self.logarithmic && !(is_number && positive) { Err(SweepError::Logarithm(name)) } else { Ok(()) }
    }

    fn check_value(&self, value: Value) -> Result<(), SweepError> {
        let vector = value.vector();
        let reason = match self.parameter.domain() {
            _ if !vector.is_finite() => "it is not finite".into(),
            Domain::Number(low, high) if !(low..=high).contains(&vector.x) => format!("it lies from {low} to {high}"),
            Domain::Color if !(vector.min_element() >= 0.0 && vector.max_element() <= 1.0) => {
                "a color lies between 0 and 1".into()
            }
            _ => return Ok(()),
        };
        Err(SweepError::Value { parameter: self.parameter.name(), text: value.to_string(), reason })
    }

    /// The value at `share` of the way, 0 to 1.
    pub fn value(&self, share: f32) -> Value {
        let value = match (self.from, self.to) {
            (Value::Number(from), Value::Number(to)) if self.logarithmic => {
                Value::Number((from.ln() + share * (to.ln() - from.ln())).exp())
            }
            (Value::Number(from), Value::Number(to)) => Value::Number(from + share * (to - from)),
            (from, to) => Value::Vector(from.vector().lerp(to.vector(), share)),
        };
        // Return the ends exactly, despite rounding in between.
        match share {
            0.0 => self.from,
            1.0 => self.to,
            _ if self.parameter == Parameter::IllumCut => Value::Number(value.number().round()),
            _ => value,
        }
    }

    /// Sets the parameter to its value at `share` of the way.
    ///
    /// # Errors
    /// As [`Parameter::set`].
    pub fn apply(&self, look: &mut Look, share: f32) -> Result<(), SweepError> {
        self.parameter.set(look, self.of.as_deref(), self.value(share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::brdf::BrdfModel;
    use lapidary_render::{BrdfSampling, test_looks::look};

    fn sweep(text: &str) -> Sweep {
        text.parse().unwrap()
    }

    fn refused(text: &str) -> String {
        text.parse::<Sweep>().unwrap_err().to_string()
    }

    #[test]
    fn linear_sweeps_go_in_steps_and_logarithmic_ones_in_ratios() {
        let values = |text: &str| [0.0, 0.5, 1.0].map(|share| sweep(text).value(share).number());
        assert_eq!(values("roughness=0.25..0.75"), [0.25, 0.5, 0.75]);
        let [from, middle, to] = values("intensity=log:0.01..100");
        assert!((middle - 1.0).abs() < 1e-5 && from == 0.01 && to == 100.0);
        assert_eq!(values("illum-cut=log:1..512"), [1.0, 23.0, 512.0], "a cut has whole nodes");
        assert_eq!(values("rotation=90..-90"), [90.0, 0.0, -90.0]);
        let place = sweep("light-position@key=0,1,0..2,1,-4").value(0.5);
        assert_eq!(place, Value::Vector(Vec3::new(1.0, 1.0, -2.0)));
    }

    #[test]
    fn an_unknown_parameter_is_told_with_the_list_of_those_there_are() {
        let message = refused("glossiness=0..1");
        assert!(message.contains("glossiness"));
        for parameter in Parameter::all() {
            assert!(message.contains(&parameter.name()), "{message}");
        }
    }

    #[test]
    fn what_is_no_sweep_says_what_is_wrong() {
        for bad in ["roughness", "roughness=0.5", "roughness=", "=0..1", "roughness=0.1-0.5"] {
            assert!(bad.parse::<Sweep>().is_err(), "{bad}");
        }
        assert!(refused("roughness=0..1.5").contains("0 to 1"));
        assert!(refused("roughness=0..nan").contains("not a number"));
        assert!(refused("base-color=0,0,0..1,1,2").contains("between 0 and 1"));
        assert!(refused("eye=1,2..1,2,3").contains("three numbers"));
        assert!(refused("intensity=log:0..1").contains("above 0"));
        assert!(refused("base-color=log:0.1,0.1,0.1..1,1,1").contains("log:"));
        assert!(refused("exposure@a=0..1").contains("@"));
        assert!(refused("illum-cut=0..64").contains("1 to 32768"));
    }

    #[test]
    fn every_parameter_changes_its_own_part_of_the_look() {
        let others = [
            "bump=0..0.15",
            "normal=0..0.16",
            "rotation=0..17",
            "intensity=0..0.18",
            "exposure=0..0.19",
            "illum-cut=1..20",
            "lit-cuts=0..0.205",
            "light-intensity=0..0.21",
            "light-position=0,0,0..9,9,1",
            "light-target=0,0,0..9,9,2",
            "eye=0,0,0..9,9,3",
            "target=0,0,0..9,9,4",
            "fov=1..22",
            "f-number=1..2.3",
            "focus=1..2.4",
        ];
        let declared = Parameter::all().filter_map(|parameter| match (parameter, parameter.domain()) {
            (Parameter::Brdf(_), Domain::Number(low, high)) => {
                Some(format!("{}={low}..{}", parameter.name(), low + 0.37 * (high - low)))
            }
            (Parameter::Brdf(_), _) => Some(format!("{}=0,0,0..0.2,0.3,0.4", parameter.name())),
            _ => None,
        });
        let all: Vec<String> = declared.chain(others.map(str::to_owned)).collect();
        assert_eq!(all.len(), Parameter::all().count());
        let shown = |look: &Look| {
            format!(
                "{:?} {} {} {:?} {} {} {:?} {:?}",
                look.appearance.materials,
                look.illumination.rotation,
                look.illumination.intensity,
                look.post,
                look.illum_cut,
                look.tau,
                look.lights,
                look.view
            )
        };
        let mut seen = vec![shown(&look())];
        for text in &all {
            let sweep = sweep(text);
            let stored = sweep.parameter == Parameter::IllumCut;
            let mut changed =
                Look { sampling: if stored { BrdfSampling::Refine } else { BrdfSampling::Lit }, ..look() };
            if let Parameter::Brdf(name) = sweep.parameter {
                let reads = BrdfModel::ALL.iter().find(|model| model.parameter(name).is_some()).unwrap();
                changed.appearance.materials.iter_mut().for_each(|material| material.change_model(*reads));
            }
            sweep.apply(&mut changed, 1.0).unwrap();
            let shown = shown(&changed);
            assert!(!seen.contains(&shown), "{text} changes nothing, or the same as another");
            seen.push(shown);
        }
    }

    #[test]
    fn cuts_that_are_not_merged_cannot_be_swept() {
        let message = |text: &str, sampling| {
            let applied = sweep(text).apply(&mut Look { sampling, ..look() }, 0.5);
            applied.err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(message("illum-cut=1..9", BrdfSampling::Lit).contains("--brdf refine"));
        for stored in [BrdfSampling::Refine, BrdfSampling::Once] {
            assert!(message("lit-cuts=0..1", stored).contains("--brdf lit"));
            assert_eq!(message("illum-cut=1..9", stored), "", "negative control");
        }
        assert_eq!(message("lit-cuts=log:0.001..1", BrdfSampling::Lit), "", "negative control");
    }

    #[test]
    fn a_quantity_is_swept_under_the_name_of_the_model_and_one_that_none_has_is_refused() {
        let mut changed = look();
        changed.appearance.materials.iter_mut().for_each(|material| material.change_model(BrdfModel::OpenPbr));
        sweep("roughness=0..0.9").apply(&mut changed, 1.0).unwrap();
        assert_eq!(changed.appearance.materials[0].parameters.number("specular_roughness"), 0.9);
        let refused = sweep("coat-weight=0..1").apply(&mut look(), 1.0).unwrap_err().to_string();
        assert!(refused.contains("coat-weight") && refused.contains("lapidary models"), "{refused}");
    }

    #[test]
    fn names_choose_one_material_or_light() {
        let mut changed = look();
        sweep("roughness@gold=0..0.9").apply(&mut changed, 1.0).unwrap();
        let roughness = |i: usize| changed.appearance.materials[i].parameters.number("roughness");
        assert_eq!((roughness(0), roughness(1)), (0.9, 0.5));
        let message = sweep("roughness@tin=0..1").apply(&mut look(), 0.0).unwrap_err().to_string();
        assert!(message.contains("tin") && message.contains("gold, wood"), "{message}");
        let message = sweep("light-intensity@fill=0..1").apply(&mut look(), 0.0).unwrap_err().to_string();
        assert!(message.contains("fill") && message.contains("key"), "{message}");
    }

    #[test]
    fn a_place_is_of_one_light_and_a_map_must_be_there() {
        let mut two = look();
        two.lights = [two.lights[0].clone(), Light { name: "rim".into(), ..two.lights[0].clone() }].into();
        let message = sweep("light-position=0,0,0..1,1,1").apply(&mut two, 0.0).unwrap_err().to_string();
        assert!(message.contains("@") && message.contains("key, rim"), "{message}");
        sweep("light-position@rim=0,0,0..7,7,7").apply(&mut two, 1.0).unwrap();
        assert_eq!((two.lights[0].position, two.lights[1].position), (look().lights[0].position, Vec3::splat(7.0)));
        let mut bare = look();
        bare.appearance.materials.iter_mut().for_each(|material| material.maps = Default::default());
        assert!(sweep("bump=0..1").apply(&mut bare, 0.0).unwrap_err().to_string().contains("bump map"));
    }

    #[test]
    fn captions_have_few_digits() {
        let text = |number: f32| Value::Number(number).to_string();
        assert_eq!(
            [0.05, 0.123_456, 12.345_6, 512.0, -7.5, 0.0, 32_768.0].map(text),
            ["0.05", "0.1235", "12.35", "512", "-7.5", "0", "32768"]
        );
    }

    use lapidary_core::lights::Light;
}
