//! The meshless solution at any surface point, for display: each pixel sums the functions that reach it and normalizes them level
//! by level (meshless paper, 4.1, with the loop inverted). The basis limits the detail, not the mesh.

use super::gloss::ArrivingByDirection;
use glam::{Mat3A, Vec3};
use lapidary_core::{
    color::{luminance, signed_light},
    dataset::Dataset,
    mesh::Mesh,
    meshless::{FunctionPlace, Functions},
};
use rayon::prelude::*;
use std::{f32::consts::FRAC_1_PI, fmt, sync::Arc};

/// Radius of a function's marker in [`MeshlessLight::marked_level`], in radii of its support. Points of the finest level are at
/// least 0.4 radii apart, so markers do not touch.
pub(crate) const POINT_RADIUS: f32 = 0.08;

/// Bounced light as coefficients of meshless functions: of a dataset's basis, or of those of its objects, which go with them.
#[derive(Clone)]
pub struct MeshlessLight {
    dataset: Arc<Dataset>,
    /// The vertices as baked, if the functions are those of objects. Their levels hold absolute values, each finer than the one
    /// before; those of a basis are summed.
    as_baked: Option<Arc<VerticesAsBaked>>,
    coefficients: Vec<Mat3A>,
    /// The same light by direction, for glossy surfaces.
    by_direction: Option<Arc<ArrivingByDirection>>,
    /// Whether any function in the cell of each grid slot carries light; empty for functions of objects. Most cells of the finest
    /// levels of a basis have none.
    is_lit: Vec<bool>,
}

/// Where the vertices of a scene were as baked, with those of hidden objects where they would be.
#[derive(Debug)]
pub struct VerticesAsBaked {
    /// Positions in meters.
    pub positions: Vec<Vec3>,
    /// The object of each.
    pub owners: Vec<u32>,
}

impl VerticesAsBaked {
    /// The vertices of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        Self { positions: mesh.positions.clone(), owners: mesh.owners() }
    }
}

impl fmt::Debug for MeshlessLight {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("MeshlessLight").field("coefficients", &self.coefficients.len()).finish_non_exhaustive()
    }
}

impl MeshlessLight {
    /// Light of a dataset's basis by `coefficients`: vector irradiance in W/m², one column per color channel. `None` if the
    /// dataset has no meshless basis.
    ///
    /// # Panics
    /// If `coefficients` does not have one entry per function.
    pub fn new(dataset: &Arc<Dataset>, coefficients: Vec<Mat3A>) -> Option<Self> {
        let bake = dataset.meshless.as_ref()?;
        assert_eq!(bake.basis.len(), coefficients.len(), "one coefficient per function");
        let grid = bake.basis.functions().grid();
        let is_lit = |slot: usize| grid.functions_in(slot).iter().any(|&f| coefficients[f as usize] != Mat3A::ZERO);
        let is_lit = (0..grid.slots().len()).into_par_iter().with_min_len(1024).map(is_lit).collect();
        Some(Self { dataset: dataset.clone(), as_baked: None, coefficients, by_direction: None, is_lit })
    }

    /// Light of the functions of a dataset's objects, with its vertices. `None` if the dataset has no such functions.
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn of_objects(
        dataset: &Arc<Dataset>,
        as_baked: &Arc<VerticesAsBaked>,
        coefficients: Vec<Mat3A>,
    ) -> Option<Self> {
        assert_eq!(dataset.object_bases.as_ref()?.len(), coefficients.len(), "one coefficient per function");
        let (as_baked, by_direction, is_lit) = (Some(as_baked.clone()), None, Vec::new());
        Some(Self { dataset: dataset.clone(), as_baked, coefficients, by_direction, is_lit })
    }

    /// The same functions with other coefficients.
    #[must_use]
    pub fn with_coefficients(&self, coefficients: Vec<Mat3A>) -> Self {
        let Self { dataset, as_baked, .. } = self;
        let light = match as_baked {
            Some(as_baked) => Self::of_objects(dataset, as_baked, coefficients),
            None => Self::new(dataset, coefficients),
        };
        light.expect("the dataset has these functions")
    }

    /// The same light, of which also directions are known.
    #[must_use]
    pub(super) fn arriving_from(self, by_direction: ArrivingByDirection) -> Self {
        Self { by_direction: Some(by_direction.into()), ..self }
    }

    /// The light by direction, if it is known.
    pub(crate) fn by_direction(&self) -> Option<&Arc<ArrivingByDirection>> {
        self.by_direction.as_ref()
    }

    /// The dataset of these functions.
    pub fn dataset(&self) -> &Arc<Dataset> {
        &self.dataset
    }

    /// The vertices as baked, if the functions are those of objects.
    pub fn as_baked(&self) -> Option<&Arc<VerticesAsBaked>> {
        self.as_baked.as_ref()
    }

    /// Whether both are of the same functions: a coefficient of one stands for the same function of the other.
    pub(crate) fn has_functions_of(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|light| (light.as_baked.is_some(), light.functions()));
        let [of_a, of_b] = [a.1, b.1].map(|functions| functions.points().iter().map(|point| point.place));
        a.0 == b.0 && a.1.offsets() == b.1.offsets() && of_a.eq(of_b)
    }

    /// The functions.
    pub fn functions(&self) -> &Functions {
        let Dataset { meshless, object_bases, .. } = &*self.dataset;
        let of_objects = || object_bases.as_ref().expect("it was made with functions of objects").functions();
        let of_scene = || meshless.as_ref().expect("it was made with a basis").basis.functions();
        if self.as_baked.is_some() { of_objects() } else { of_scene() }
    }

    /// Vector irradiance of each function in W/m², one column per color channel.
    pub fn coefficients(&self) -> &[Mat3A] {
        &self.coefficients
    }

    /// A point of a triangle among the functions, from its place in the picture. Those of objects lie on the scene as baked, so the
    /// point is found there by its vertices and barycentric coordinates; `None` on an object without functions.
    pub fn place(
        &self,
        shown: FunctionPlace,
        vertices: [u32; 3],
        barycentric: Vec3,
        from_behind: bool,
    ) -> Option<FunctionPlace> {
        let Some(as_baked) = &self.as_baked else { return Some(shown) };
        let [a, b, c] = vertices.map(|vertex| as_baked.positions[vertex as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero() * if from_behind { -1.0 } else { 1.0 };
        let position = a * barycentric.x + b * barycentric.y + c * barycentric.z;
        self.dataset.object_bases.as_ref()?.place(as_baked.owners[vertices[0] as usize], position, normal)
    }

    /// Vector irradiance at a surface point. Functions lie on faces, so its normal is the face's on the visible side.
    /// Interpolated normals have a larger error: 0.095 in place of 0.087 in the bathroom.
    ///
    /// Functions of objects: the finest level that reaches the point. A basis: the sum of all levels. There a back is lit if a
    /// function of the finest level reaches it. Normals of open shells often point away from the visible side,
    /// and functions lie on the lit side (meshless paper, 2.2, Eq. 8). A visible back has a fine function close to it. Coarser
    /// functions also reach hidden backs, through walls.
    #[inline]
    pub fn at(&self, place: &FunctionPlace, from_behind: bool) -> Mat3A {
        let (functions, levels) = (self.functions(), 0..self.functions().levels());
        let of_level = |level: usize| {
            let slot = functions.slot_at(level, place);
            let is_lit = self.is_lit.get(slot).is_none_or(|&lit| lit);
            is_lit.then(|| functions.evaluate_in(slot, level, place, &self.coefficients)).flatten()
        };
        if self.as_baked.is_some() {
            return levels.rev().find_map(of_level).unwrap_or(Mat3A::ZERO);
        }
        if from_behind && !is_back_lit(functions, place) {
            return Mat3A::ZERO;
        }
        levels.filter_map(of_level).fold(Mat3A::ZERO, |sum, of_level| sum + of_level)
    }

    /// The part of one level in the light that a white surface reflects: red where positive, blue where negative (meshless
    /// paper, Fig. 3). Black beyond the last level.
    pub(crate) fn level_part(&self, level: u32, place: &FunctionPlace, shading_normal: Vec3) -> Vec3 {
        let (functions, level) = (self.functions(), level as usize);
        if level >= functions.levels() {
            return Vec3::ZERO;
        }
        let vector = functions.evaluate_in(functions.slot_at(level, place), level, place, &self.coefficients);
        let received = vector.unwrap_or(Mat3A::ZERO).transpose().mul_vec3(shading_normal);
        signed_light(luminance(received) * FRAC_1_PI)
    }

    /// Value of one function at a point, 0 to 1 (meshless paper, Fig. 4).
    pub(crate) fn function_value(&self, function: u32, place: &FunctionPlace) -> f32 {
        let functions = self.functions();
        let level = (0..functions.levels()).find(|&level| functions.level(level).contains(&(function as usize)));
        let mut values = Vec::new();
        level.into_iter().for_each(|level| functions.values(level, place, &mut values));
        values.iter().find(|(found, _)| *found == function).map_or(0.0, |(_, value)| *value)
    }

    /// The finest level that has a function with a nonzero coefficient and a center close to the point (meshless paper, Fig. 1).
    pub(crate) fn marked_level(&self, place: &FunctionPlace) -> Option<usize> {
        let functions = self.functions();
        (0..functions.levels()).rev().find(|&level| {
            let reach = POINT_RADIUS * functions.radii()[level];
            let mut is_marked = false;
            functions.for_each_weight(level, place, |function, _| {
                let center = functions.points()[function as usize].position;
                let near = center.distance_squared(place.position) < reach * reach;
                is_marked |= near && self.coefficients[function as usize] != Mat3A::ZERO;
            });
            is_marked
        })
    }
}

/// Whether the back at a point receives light; see [`MeshlessLight::at`].
pub(crate) fn is_back_lit(functions: &Functions, place: &FunctionPlace) -> bool {
    functions.reaches(functions.levels() - 1, place)
}

/// Color of a level: hues from red to magenta.
pub(crate) fn level_color(level: usize, levels: usize) -> Vec3 {
    let hue = level as f32 / levels as f32;
    let channel = |shift: f32| (((hue + shift).fract() * 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
    Vec3::new(channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{
        light::implicit::tests::blocked,
        test_scenes::{self, white},
    };
    use glam::Vec2;
    use lapidary_core::{
        brdf::GgxParameters,
        meshless::{Basis, MeshlessBake, ObjectBases, Owner, Transport},
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

    fn below(position: Vec3) -> FunctionPlace {
        FunctionPlace::new(position, Vec3::NEG_Y)
    }

    /// A dataset with functions of its objects at the front of each triangle, and coarser ones at that of every fifth.
    pub(crate) fn with_functions_of_objects(mut dataset: Dataset) -> Dataset {
        let mesh = &dataset.scene.mesh;
        let function = |triangle: u32| {
            let at = mesh.surfel(triangle, Vec2::splat(1.0 / 3.0), false);
            (at, Owner::on(mesh, &at))
        };
        let mut functions: Vec<(Surfel, Owner)> = (0..mesh.triangles.len() as u32).map(function).collect();
        functions.sort_by_key(|(_, owner)| owner.object);
        let coarse = functions.iter().step_by(5).copied().collect();
        dataset.object_bases = Some(ObjectBases::new(&[coarse, functions], vec![2.0, 0.8], 0).unwrap().into());
        dataset
    }

    #[test]
    fn functions_of_an_object_light_it_alone_wherever_it_is() {
        let dataset = Arc::new(with_functions_of_objects(blocked(white(), 8)));
        let (mesh, bases) = (&dataset.scene.mesh, dataset.object_bases.as_ref().unwrap());
        let as_baked = VerticesAsBaked::of(mesh).into();
        // Another light for each object and level; that of the coarse level never shows where the fine one reaches.
        let of = |function: usize| {
            let (object, level) = (bases.owners()[function].object, bases.level_of(function as u32));
            Mat3A::IDENTITY * (1.0 + object as f32 + 10.0 * (1 - level) as f32)
        };
        let coefficients: Vec<Mat3A> = (0..bases.len()).map(of).collect();
        let light = MeshlessLight::of_objects(&dataset, &as_baked, coefficients).unwrap();
        for (triangle, &vertices) in mesh.triangles.iter().enumerate() {
            let object = mesh.triangle_object[triangle];
            // Wherever the picture shows it: here all lie upon each other.
            let shown = FunctionPlace::new(Vec3::ZERO, Vec3::Y);
            let place = light.place(shown, vertices, Vec3::splat(1.0 / 3.0), false).unwrap();
            assert!(light.at(&place, false).abs_diff_eq(Mat3A::IDENTITY * (1.0 + object as f32), 1e-5), "{triangle}");
        }
        let blocker = mesh.triangles[mesh.triangles.len() - 1];
        let of_blocker = light.place(below(Vec3::ZERO), blocker, Vec3::splat(1.0 / 3.0), false).unwrap();
        let of_floor = FunctionPlace { first_key: 0, ..of_blocker };
        assert_ne!(light.at(&of_floor, false), light.at(&of_blocker, false), "negative control: the floor's functions");
        let other = Arc::new(with_functions_of_objects(blocked(white(), 10)));
        let count = other.object_bases.as_ref().unwrap().len();
        let other = MeshlessLight::of_objects(&other, &as_baked, vec![Mat3A::ZERO; count]).unwrap();
        assert!(light.has_functions_of(&light.clone()) && !light.has_functions_of(&other));
        let dark = light.with_coefficients(vec![Mat3A::ZERO; bases.len()]);
        assert!(dark.as_baked().is_some() && dark.at(&of_blocker, false) == Mat3A::ZERO);
    }

    #[test]
    fn it_is_the_sum_of_values_times_coefficients() {
        let light = light();
        let mut random = fastrand::Rng::with_seed(3);
        let sum_by_values = |position: Vec3| {
            let mut values = Vec::new();
            (0..2).for_each(|level| light.functions().values(level, &below(position), &mut values));
            values.iter().fold(Mat3A::ZERO, |sum, &(j, value)| sum + light.coefficients[j as usize] * value)
        };
        let mut lit = 0;
        for _ in 0..500 {
            let position = Vec3::new(2.0 * random.f32(), 0.0, 2.0 * random.f32());
            let found = light.at(&below(position), false);
            assert!(found.abs_diff_eq(sum_by_values(position), 1e-5), "{position}");
            lit += u32::from(found != Mat3A::ZERO && !found.abs_diff_eq(sum_by_values(Vec3::ZERO), 1e-3));
        }
        assert!(lit > 50, "negative control: it differs from place to place");
    }

    #[test]
    fn backs_are_lit_where_a_fine_function_reaches_them() {
        let light = light();
        let under_coarse_alone = Vec3::new(0.2, 0.0, 0.2);
        assert!(light.at(&below(under_coarse_alone), false) != Mat3A::ZERO, "negative control: as a front");
        assert_eq!(light.at(&below(under_coarse_alone), true), Mat3A::ZERO);
        let under_fine = Vec3::new(1.6, 0.0, 1.9);
        assert_eq!(light.at(&below(under_fine), true), light.at(&below(under_fine), false));
        assert!(light.at(&below(under_fine), true) != Mat3A::ZERO);
        assert_eq!(light.at(&FunctionPlace::new(under_fine, Vec3::Y), true), Mat3A::ZERO, "the other side");
    }

    #[test]
    fn views_show_a_level_a_function_and_the_points_that_carry_light() {
        let light = light();
        let part = |level, x: f32| light.level_part(level, &below(Vec3::new(x, 0.0, 2.0)), Vec3::NEG_Y);
        let third = 1.0 / std::f32::consts::PI;
        assert!((part(1, 2.0).x * 0.0 + part(1, 1.0).z).is_finite());
        // Coefficients are multiples of the identity: only the green channel receives light, against the axis.
        let green = luminance(Vec3::Y);
        assert!(
            (light.level_part(0, &below(Vec3::ZERO), Vec3::NEG_Y).z - 2.0 * green * third).abs() < 1e-6,
            "2, from below"
        );
        assert!(part(1, 2.0).x > 0.0 && part(1, 2.0).z == 0.0, "-3 adds");
        assert_eq!(part(2, 2.0), Vec3::ZERO, "beyond the last level");
        let value = |function, x: f32| light.function_value(function, &below(Vec3::new(x, 0.0, 2.0)));
        assert!((value(2, 1.4) + value(3, 1.4) - 1.0).abs() < 1e-6 && value(2, 1.4) < value(3, 1.4));
        assert!(value(2, 0.0) == 0.0 && value(9, 2.0) == 0.0, "out of reach, and none such");
        let level = |x: f32, z: f32| light.marked_level(&below(Vec3::new(x, 0.0, z)));
        assert_eq!([level(2.0, 2.0), level(0.0, 0.0), level(1.5, 2.0)], [Some(1), Some(0), None]);
        assert_eq!(light.marked_level(&below(Vec3::Y * 50.0)), None, "its coefficient is zero");
    }

    #[test]
    fn levels_have_colors_of_their_own() {
        let colors: Vec<Vec3> = (0..6).map(|level| level_color(level, 6)).collect();
        assert_eq!(colors[0], Vec3::X);
        assert!((colors[2] - Vec3::Y).length() < 1e-5 && (colors[4] - Vec3::Z).length() < 1e-5, "{colors:?}");
    }
}
