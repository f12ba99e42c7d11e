//! The meshless solution at any surface point, for display: each pixel sums the functions that reach it and normalizes them level
//! by level (meshless paper, 4.1, with the loop inverted). The basis limits the detail, not the mesh.

use glam::{Mat3A, Vec3};
use lapidary_core::{color::luminance, dataset::Dataset, meshless::Basis};
use rayon::prelude::*;
use std::{f32::consts::FRAC_1_PI, fmt, sync::Arc};

/// Radius of a function's marker in [`MeshlessLight::marked_level`], in radii of its support. Points of the finest level are at
/// least 0.4 radii apart, so markers do not touch.
pub(crate) const POINT_RADIUS: f32 = 0.08;

/// Bounced light as coefficients of a dataset's meshless basis.
#[derive(Clone)]
pub struct MeshlessLight {
    dataset: Arc<Dataset>,
    coefficients: Vec<Mat3A>,
    /// Whether any function in the cell of each grid slot carries light. Most cells of the finest levels have none.
    is_lit: Vec<bool>,
}

impl fmt::Debug for MeshlessLight {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("MeshlessLight").field("coefficients", &self.coefficients.len()).finish_non_exhaustive()
    }
}

impl MeshlessLight {
    /// Light of a dataset's functions by `coefficients`: vector irradiance in W/m², one column per color channel. `None` if the
    /// dataset has no meshless basis.
    ///
    /// # Panics
    /// If `coefficients` does not have one entry per function.
    pub fn new(dataset: &Arc<Dataset>, coefficients: Vec<Mat3A>) -> Option<Self> {
        let bake = dataset.meshless.as_ref()?;
        assert_eq!(bake.basis.len(), coefficients.len(), "one coefficient per function");
        let grid = bake.basis.grid();
        let is_lit = |slot: usize| grid.functions_in(slot).iter().any(|&f| coefficients[f as usize] != Mat3A::ZERO);
        let is_lit = (0..grid.slots().len()).into_par_iter().with_min_len(1024).map(is_lit).collect();
        Some(Self { dataset: dataset.clone(), coefficients, is_lit })
    }

    /// The dataset of these functions.
    pub fn dataset(&self) -> &Arc<Dataset> {
        &self.dataset
    }

    /// The functions.
    pub fn basis(&self) -> &Basis {
        &self.dataset.meshless.as_ref().expect("it was made with a basis").basis
    }

    /// Vector irradiance of each function in W/m², one column per color channel.
    pub fn coefficients(&self) -> &[Mat3A] {
        &self.coefficients
    }

    /// Vector irradiance at a surface point. Functions lie on faces, so `normal` is the face's unit normal on the visible side.
    /// Interpolated normals have a larger error: 0.095 in place of 0.087 in the bathroom.
    ///
    /// A back is lit if a function of the finest level reaches it. Normals of open shells often point away from the visible side,
    /// and functions lie on the lit side (meshless paper, 2.2, Eq. 8). A visible back has a fine function close to it. Coarser
    /// functions also reach hidden backs, through walls.
    #[inline]
    pub fn at(&self, position: Vec3, normal: Vec3, from_behind: bool) -> Mat3A {
        if from_behind && !is_back_lit(self.basis(), position, normal) {
            return Mat3A::ZERO;
        }
        let basis = self.basis();
        (0..basis.levels()).fold(Mat3A::ZERO, |sum, level| {
            let slot = basis.grid().slot_at(level, position);
            match self.is_lit[slot] {
                true => sum + basis.evaluate_in(slot, level, (position, normal), &self.coefficients),
                false => sum,
            }
        })
    }

    /// Contribution of one level to the light that a white surface reflects: red where positive, blue where negative (meshless
    /// paper, Fig. 3). Black beyond the last level.
    pub(crate) fn level_part(&self, level: u32, position: Vec3, [normal, shading]: [Vec3; 2]) -> Vec3 {
        let basis = self.basis();
        if level as usize >= basis.levels() {
            return Vec3::ZERO;
        }
        let vector = basis.evaluate_level(level as usize, position, normal, &self.coefficients);
        let reflected = luminance(vector.transpose().mul_vec3(shading)) * FRAC_1_PI;
        Vec3::new(reflected, 0.0, -reflected).max(Vec3::ZERO)
    }

    /// Value of one function at a point, 0 to 1 (meshless paper, Fig. 4).
    pub(crate) fn function_value(&self, function: u32, position: Vec3, normal: Vec3) -> f32 {
        let basis = self.basis();
        let level = (0..basis.levels()).find(|&level| basis.level(level).contains(&(function as usize)));
        let mut values = Vec::new();
        level.into_iter().for_each(|level| basis.values(level, position, normal, &mut values));
        values.iter().find(|(found, _)| *found == function).map_or(0.0, |(_, value)| *value)
    }

    /// The finest level that has a function with a nonzero coefficient and a center close to the point (meshless paper, Fig. 1).
    pub(crate) fn marked_level(&self, position: Vec3, normal: Vec3) -> Option<usize> {
        let basis = self.basis();
        (0..basis.levels()).rev().find(|&level| {
            let reach = POINT_RADIUS * basis.radii()[level];
            let mut is_marked = false;
            basis.for_each_weight(level, position, normal, |function, _| {
                let near = basis.points()[function as usize].position.distance_squared(position) < reach * reach;
                is_marked |= near && self.coefficients[function as usize] != Mat3A::ZERO;
            });
            is_marked
        })
    }
}

/// Whether the back at a point receives light; see [`MeshlessLight::at`].
pub(crate) fn is_back_lit(basis: &Basis, position: Vec3, normal: Vec3) -> bool {
    basis.reaches(basis.levels() - 1, position, normal)
}

/// Color of a level: hues from red to magenta.
pub(crate) fn level_color(level: usize, levels: usize) -> Vec3 {
    let hue = level as f32 / levels as f32;
    let channel = |shift: f32| (((hue + shift).fract() * 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
    Vec3::new(channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes;
    use lapidary_core::{
        brdf::GgxParameters,
        meshless::{MeshlessBake, Transport},
        surfel::Surfel,
    };

    /// A floor with light only on its back near one corner, from a distant sender.
    fn light() -> MeshlessLight {
        let mut dataset = test_scenes::dataset(test_scenes::mesh(8, false), GgxParameters::default());
        let at = |position: Vec3, normal: Vec3| Surfel { position, normal, ..Default::default() };
        let corner = Vec3::new(2.0, 0.0, 2.0);
        let coarse = vec![at(Vec3::Y * 50.0, Vec3::NEG_Y), at(Vec3::ZERO, Vec3::NEG_Y)];
        let fine = vec![at(corner, Vec3::NEG_Y), at(corner - Vec3::X, Vec3::NEG_Y)];
        let basis = Basis::new(&[coarse, fine], 1.0, 1).unwrap();
        let link = |y: f32| vec![(0, Vec3::new(0.1, y, 0.0))];
        let transport = Transport::from_rows(&[Vec::new(), link(-0.9), link(-0.5), link(-0.2)], 2);
        dataset.meshless = Some(MeshlessBake { basis, transport }.into());
        let coefficients = [0.0, 2.0, -3.0, 4.0].map(|x| Mat3A::IDENTITY * x).to_vec();
        MeshlessLight::new(&dataset.into(), coefficients).unwrap()
    }

    #[test]
    fn it_is_the_sum_of_values_times_coefficients() {
        let light = light();
        let mut random = fastrand::Rng::with_seed(3);
        let sum_by_values = |position: Vec3| {
            let mut values = Vec::new();
            (0..2).for_each(|level| light.basis().values(level, position, Vec3::NEG_Y, &mut values));
            values.iter().fold(Mat3A::ZERO, |sum, &(j, value)| sum + light.coefficients[j as usize] * value)
        };
        let mut lit = 0;
        for _ in 0..500 {
            let position = Vec3::new(2.0 * random.f32(), 0.0, 2.0 * random.f32());
            let found = light.at(position, Vec3::NEG_Y, false);
            assert!(found.abs_diff_eq(sum_by_values(position), 1e-5), "{position}");
            lit += u32::from(found != Mat3A::ZERO && !found.abs_diff_eq(sum_by_values(Vec3::ZERO), 1e-3));
        }
        assert!(lit > 50, "negative control: it differs from place to place");
    }

    #[test]
    fn backs_are_lit_where_a_fine_function_reaches_them() {
        let light = light();
        let under_coarse_alone = Vec3::new(0.2, 0.0, 0.2);
        assert!(light.at(under_coarse_alone, Vec3::NEG_Y, false) != Mat3A::ZERO, "negative control: as a front");
        assert_eq!(light.at(under_coarse_alone, Vec3::NEG_Y, true), Mat3A::ZERO);
        let under_fine = Vec3::new(1.6, 0.0, 1.9);
        assert_eq!(light.at(under_fine, Vec3::NEG_Y, true), light.at(under_fine, Vec3::NEG_Y, false));
        assert!(light.at(under_fine, Vec3::NEG_Y, true) != Mat3A::ZERO);
        assert_eq!(light.at(under_fine, Vec3::Y, true), Mat3A::ZERO, "the other side");
    }

    #[test]
    fn views_show_a_level_a_function_and_the_points_that_carry_light() {
        let light = light();
        let down = [Vec3::NEG_Y; 2];
        let part = |level, x: f32| light.level_part(level, Vec3::new(x, 0.0, 2.0), down);
        let third = 1.0 / std::f32::consts::PI;
        assert!((part(1, 2.0).x * 0.0 + part(1, 1.0).z).is_finite());
        // Coefficients are multiples of the identity: only the green channel receives light, against the axis.
        let green = luminance(Vec3::Y);
        assert!((light.level_part(0, Vec3::ZERO, down).z - 2.0 * green * third).abs() < 1e-6, "2, from below");
        assert!(part(1, 2.0).x > 0.0 && part(1, 2.0).z == 0.0, "-3 adds");
        assert_eq!(part(2, 2.0), Vec3::ZERO, "beyond the last level");
        let value = |function, x: f32| light.function_value(function, Vec3::new(x, 0.0, 2.0), Vec3::NEG_Y);
        assert!((value(2, 1.4) + value(3, 1.4) - 1.0).abs() < 1e-6 && value(2, 1.4) < value(3, 1.4));
        assert!(value(2, 0.0) == 0.0 && value(9, 2.0) == 0.0, "out of reach, and none such");
        let level = |x: f32, z: f32| light.marked_level(Vec3::new(x, 0.0, z), Vec3::NEG_Y);
        assert_eq!([level(2.0, 2.0), level(0.0, 0.0), level(1.5, 2.0)], [Some(1), Some(0), None]);
        assert_eq!(light.marked_level(Vec3::Y * 50.0, Vec3::NEG_Y), None, "its coefficient is zero");
    }

    #[test]
    fn levels_have_colors_of_their_own() {
        let colors: Vec<Vec3> = (0..6).map(|level| level_color(level, 6)).collect();
        assert_eq!(colors[0], Vec3::X);
        assert!((colors[2] - Vec3::Y).length() < 1e-5 && (colors[4] - Vec3::Z).length() < 1e-5, "{colors:?}");
    }
}
