//! Units of values (MaterialX, *Units*): lengths become meters, and angles degrees.

use super::{Graph, XmlNode};

/// Units of the standard library, each in meters or degrees.
const UNITS: [(&str, f32); 13] = [
    ("nanometer", 1e-9),
    ("micron", 1e-6),
    ("micrometer", 1e-6),
    ("millimeter", 1e-3),
    ("centimeter", 0.01),
    ("meter", 1.0),
    ("kilometer", 1000.0),
    ("inch", 0.0254),
    ("foot", 0.3048),
    ("yard", 0.9144),
    ("mile", 1609.344),
    ("degree", 1.0),
    ("radian", 180.0 / std::f32::consts::PI),
];

/// The input of OpenPBR whose number is in micrometers.
const IN_MICROMETERS: &str = "thin_film_thickness";

impl Graph<'_> {
    /// Factor from the unit of a value to the unit that it is read in. An unknown unit gives a remark.
    pub(super) fn unit_factor(&self, told: XmlNode) -> f32 {
        let Some(unit) = told.attribute("unit").filter(|unit| !unit.is_empty()) else { return 1.0 };
        let Some((_, factor)) = UNITS.iter().find(|(name, _)| *name == unit) else {
            let name = told.attribute("name").unwrap_or_default();
            self.remark(
                told,
                &format!("the unit \"{unit}\" of \"{name}\" is not known, and its number is taken as it is"),
            );
            return 1.0;
        };
        if told.attribute("name") == Some(IN_MICROMETERS) { factor * 1e6 } else { *factor }
    }
}
