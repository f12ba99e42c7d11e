//! BRDFs that users write: a file in WGSL with a function `brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32>`, the
//! BRDF without its cosine in the local frame, with comments that declare its parameters (`head.rs`).
//!
//! Shaders get the text of the module that naga parsed, with renamed items and counted loops. The CPU interprets the
//! same module. Lobe and sampling are estimated from values: see [`SampledLobe`].

mod check;
mod head;
mod instrument;
mod machine;
mod operations;
#[cfg(test)]
mod tests;
mod trial;
mod values;

pub use check::SIGNATURE;
pub(super) use head::all_declared;

use super::{Parameter, SurfaceParameters, Values, sampled::SampledLobe};
use glam::Vec3;
use machine::Machine;
use naga::{
    Function, GlobalVariable, Handle, Module, Span,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};
use std::sync::{Arc, PoisonError, RwLock};
use thiserror::Error;
use values::{Flat, Val};

/// Largest number of statements in an evaluation on the CPU.
const MOST_STATEMENTS: u32 = 100_000;
/// Number of cached estimates: one per set of parameters, such as materials or steps of a slider.
const KEPT_ESTIMATES: usize = 16;
/// Largest valid BRDF value.
const MOST_VALUE: f32 = 1e6;

/// A BRDF that a user wrote.
#[derive(Debug)]
pub struct Written {
    text: String,
    /// Parameters declared by the file, followed by those of all materials.
    parameters: &'static [Parameter],
    module: Module,
    root: Handle<Function>,
    counter: Handle<GlobalVariable>,
    remarks: Vec<String>,
    hash: [u8; 32],
    /// Estimates, keyed by the numbers of their parameters.
    estimates: RwLock<Vec<(Vec<u32>, Arc<SampledLobe>)>>,
}

/// Why a text is not a valid BRDF.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{}{reason}{}", place.as_ref().map_or(String::new(), |(line, _)| format!("line {line}: ")),
    place.as_ref().map_or(String::new(), |(_, source)| format!(": `{source}`")))]
pub struct WrittenError {
    /// The line, from 1, and its text.
    pub place: Option<(usize, String)>,
    /// The problem and its remedy.
    pub reason: String,
}

impl WrittenError {
    fn whole(reason: String) -> Self {
        Self { place: None, reason }
    }

    fn at(text: &str, line: usize, reason: String) -> Self {
        let source = text.lines().nth(line.saturating_sub(1)).unwrap_or_default().trim();
        Self { place: Some((line, source.to_owned())), reason }
    }

    fn in_span(text: &str, span: Span, reason: String) -> Self {
        let is_inside = span.to_range().is_some_and(|range| range.start < text.len());
        if span.is_defined() && is_inside {
            Self::at(text, span.location(text).line_number as usize, reason)
        } else {
            Self::whole(reason)
        }
    }
}

/// Parameters that a file declares, without those of all materials.
fn own(parameters: &'static [Parameter]) -> &'static [Parameter] {
    &parameters[..parameters.len() - SurfaceParameters::LIST.len()]
}

impl Written {
    /// Longest text, in bytes.
    pub const MOST_BYTES: u64 = 256 << 10;

    /// Parses and checks the text of a file, and evaluates it for some directions.
    ///
    /// # Errors
    /// The problem, with its line if there is one.
    pub fn new(text: &str) -> Result<Self, WrittenError> {
        if text.len() as u64 > Self::MOST_BYTES {
            return Err(WrittenError::whole(format!(
                "it has {} bytes, more than {}; make it shorter",
                text.len(),
                Self::MOST_BYTES
            )));
        }
        let parameters = head::parameters(text)?;
        let whole = text.to_owned() + &head::structure(own(parameters));
        let mut module = naga::front::wgsl::parse_str(&whole).map_err(|error| {
            let labels = error.labels().map(|(span, _)| span);
            let span = labels.into_iter().find(Span::is_defined).unwrap_or(Span::UNDEFINED);
            WrittenError::in_span(text, span, error.message().to_owned())
        })?;
        let root = check::check(&module, text)?;
        validated(&module).map_err(|(span, reason)| WrittenError::in_span(text, span, reason))?;
        let counter = instrument::bound(&mut module, root);
        let hash = blake3::hash(text.as_bytes()).into();
        let mut written = Self {
            text: text.to_owned(),
            parameters,
            module,
            root,
            counter,
            remarks: Vec::new(),
            hash,
            estimates: RwLock::default(),
        };
        written.wgsl("trial_").map_err(WrittenError::whole)?;
        written.remarks = trial::try_out(&written)?;
        Ok(written)
    }

    /// The file's text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Parameters that the file declares.
    pub fn parameters(&self) -> &'static [Parameter] {
        own(self.parameters)
    }

    /// Parameters of its materials: the file's, then [`SurfaceParameters`].
    pub fn material_parameters(&self) -> &'static [Parameter] {
        self.parameters
    }

    /// Remarks, in sentences without the file's name.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Hash of the text.
    pub fn hash(&self) -> [u8; 32] {
        self.hash
    }

    /// The module for shaders. All names begin with `prefix`, also the structure `Parameters` and the function `brdf`.
    ///
    /// # Errors
    /// A module that cannot be written, as a sentence.
    pub fn wgsl(&self, prefix: &str) -> Result<String, String> {
        let module = instrument::renamed(&self.module, prefix);
        let info = validated(&module).map_err(|(_, reason)| reason)?;
        naga::back::wgsl::write_string(&module, &info, naga::back::wgsl::WriterFlags::empty())
            .map_err(|error| format!("it cannot be written for shaders: {error}"))
    }

    /// The BRDF for two directions; `None` unless it is from 0 to a million.
    pub fn value(&self, parameters: &Arguments, wi: Vec3, wo: Vec3) -> Option<Vec3> {
        let value = self.evaluated(parameters, wi, wo).ok()?.0;
        is_value(value).then_some(value)
    }

    /// The unchecked BRDF, and whether it hit the step limit.
    fn evaluated(&self, parameters: &Arguments, wi: Vec3, wo: Vec3) -> Result<(Vec3, bool), machine::Endless> {
        let mut machine = Machine::new(&self.module, MOST_STATEMENTS);
        let direction = |d: Vec3| Val::Flat(Flat::floats(&d.to_array()));
        let result = machine.call(self.root, vec![parameters.0.clone(), direction(wi), direction(wo)])?;
        let value = result.map_or(Flat::float(f32::NAN), |value| value.flat());
        let steps = machine.global(self.counter).flat().bits[0];
        Ok((Vec3::new(value.f(0), value.f(1), value.f(2)), steps > instrument::MOST_STEPS))
    }

    /// The arguments for the function's parameters.
    pub fn arguments(&self, values: &Values) -> Arguments {
        let mut first = 0;
        let member = |p: &Parameter| {
            let value = values.at(first, p);
            first += p.numbers();
            let numbers = value.color().to_array();
            Val::Flat(Flat::floats(&numbers[..p.numbers()]))
        };
        Arguments(Val::Many(self.parameters().iter().map(member).collect()))
    }

    /// The lobe for some parameters. Estimates are cached for a while.
    pub fn estimate(&self, values: &Values) -> Arc<SampledLobe> {
        let own: usize = self.parameters().iter().map(Parameter::numbers).sum();
        let key: Vec<u32> = values.numbers()[..own].iter().map(|x| x.to_bits()).collect();
        let find = |known: &[(Vec<u32>, Arc<SampledLobe>)]| {
            known.iter().find(|(of, _)| *of == key).map(|(_, estimate)| estimate.clone())
        };
        if let Some(known) = find(&self.estimates.read().unwrap_or_else(PoisonError::into_inner)) {
            return known;
        }
        let mut known = self.estimates.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = find(&known) {
            return known;
        }
        let arguments = self.arguments(values);
        let estimate = Arc::new(SampledLobe::of(&|wi, wo| self.value(&arguments, wi, wo).unwrap_or_default()));
        if known.len() >= KEPT_ESTIMATES {
            known.remove(0);
        }
        known.push((key, estimate.clone()));
        estimate
    }
}

/// Parameters converted for the function of a [`Written`].
#[derive(Clone, Debug)]
pub struct Arguments(Val);

fn is_value(value: Vec3) -> bool {
    value.to_array().iter().all(|x| (0.0..=MOST_VALUE).contains(x))
}

fn validated(module: &Module) -> Result<ModuleInfo, (Span, String)> {
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    validator.validate(module).map_err(|error| {
        let span = error.spans().next().map_or(Span::UNDEFINED, |(span, _)| *span);
        let mut reason = error.as_inner().to_string();
        let mut source = std::error::Error::source(error.as_inner());
        while let Some(cause) = source {
            reason += &format!(": {cause}");
            source = cause.source();
        }
        (span, reason)
    })
}
