//! Options of the lens.

use crate::values;
use clap::Args;
use glam::Vec2;
use lapidary_core::camera::{Camera, Lens};

/// Options of the lens; what is not given stays as the camera has it.
#[derive(Args, Clone, Debug, Default, PartialEq)]
#[command(next_help_heading = "Lens")]
pub struct LensArgs {
    /// Focal length over diameter of the aperture, 0.000001 to 1000: 2.8 blurs what is out of focus, and takes 64 samples by default
    /// [default: the camera's; else all is sharp]
    #[arg(long, value_name = "N", value_parser = values::f_number)]
    pub f_number: Option<f32>,
    /// Distance from the eye to the plane of focus in meters [default: the camera's, else that of the target]
    #[arg(long, value_name = "METERS", value_parser = values::focus)]
    pub focus: Option<f32>,
    /// Height of the sensor in millimeters, 1 to 1000, to which the f-number belongs [default: the camera's, else 24]
    #[arg(long, value_name = "MM", value_parser = values::sensor)]
    pub sensor: Option<f32>,
    /// How far the picture moves to the right and up without turning the camera, in heights of it, -2 to 2 [default: the camera's]
    #[arg(long, value_name = "X,Y", value_parser = values::shift, allow_hyphen_values = true)]
    pub shift: Option<Vec2>,
}

impl LensArgs {
    /// The camera with these options.
    pub fn applied(&self, camera: Camera) -> Camera {
        let own = camera.lens;
        let lens = Lens {
            f_number: self.f_number.or(own.f_number),
            focus: self.focus.or(own.focus),
            sensor_mm: self.sensor.unwrap_or(own.sensor_mm),
            shift: self.shift.unwrap_or(own.shift),
        };
        Camera { lens, ..camera }
    }

    /// The options that give a lens, as text.
    pub fn text_of(lens: &Lens) -> String {
        let default = Lens::default();
        let option = |name: &str, value: Option<f32>| value.map(|value| format!(" --{name} {value}"));
        let options = [
            option("f-number", lens.f_number),
            option("focus", lens.focus),
            option("sensor", Some(lens.sensor_mm).filter(|mm| *mm != default.sensor_mm)),
            (lens.shift != default.shift).then(|| format!(" --shift {},{}", lens.shift.x, lens.shift.y)),
        ];
        options.into_iter().flatten().collect()
    }
}
