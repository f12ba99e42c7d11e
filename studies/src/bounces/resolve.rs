//! Times until bounced light is solved in functions of objects, and solved anew after an object moved.

use crate::timing::median;
use anyhow::{Result, anyhow};
use lapidary_core::{meshless::RadiosityStep, scene::pose::Poses};
use lapidary_render::{Baked, Changes, LightRig, Look, Posing, RadiosityRig, Relight, Situation};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Times of a solution, and of those after moves.
#[derive(Debug, Serialize)]
pub struct Resolve {
    pub object: String,
    pub functions: usize,
    /// Bounces of the solution, of which what surfaces emit is one.
    pub bounces: u32,
    /// Bytes of the rays that are kept.
    pub table_bytes: u64,
    pub moves: u32,
    /// Time of the first solution, without any rays before.
    pub whole_milliseconds: f64,
    pub whole_first_bounce_milliseconds: f64,
    /// Median time from a move to all bounces.
    pub after_a_move_milliseconds: f64,
    /// Median time from a move to its first bounce.
    pub first_bounce_milliseconds: f64,
    pub rays: u64,
    /// Mean over the moves.
    pub rays_traced_again: u64,
}

/// Solves under the light of a look, then moves an object to poses and back, `moves` times in all.
///
/// # Errors
/// A dataset without bases of objects, or places out of reach.
pub fn measured(baked: &Baked, look: &Look, object: &str, there: &Poses, moves: u32) -> Result<Resolve> {
    let without = || anyhow!("the dataset has no bases of objects; bake it with --mode radiosity or cuts,radiosity");
    let mut rig = RadiosityRig::new(baked).ok_or_else(without)?;
    let mut situation = lit(baked, look);
    let start = Instant::now();
    rig.update(&situation, Changes::ALL);
    let whole = Solved::by(&mut rig, start);
    let mut posing = Posing::new(baked);
    let (mut solved, mut again) = (Vec::new(), 0);
    for number in 0..moves {
        let poses = if number % 2 == 0 { there.clone() } else { Poses::default() };
        let start = Instant::now();
        (situation.scene, situation.poses) = (posing.posed(&poses)?, poses);
        rig.update(&situation, Changes { poses: true, ..Changes::NONE });
        solved.push(Solved::by(&mut rig, start));
        again += rig.rays().traced_again;
    }
    let bytes_of_a_ray = size_of::<lapidary_core::gather_table::GatherHit>() as u64;
    Ok(Resolve {
        object: object.into(),
        functions: baked.dataset.object_bases.as_ref().map_or(0, |bases| bases.len()),
        bounces: whole.bounces,
        table_bytes: rig.rays().kept * bytes_of_a_ray,
        moves,
        whole_milliseconds: median(vec![whole.all]),
        whole_first_bounce_milliseconds: median(vec![whole.first]),
        after_a_move_milliseconds: median(solved.iter().map(|times| times.all).collect()),
        first_bounce_milliseconds: median(solved.iter().map(|times| times.first).collect()),
        rays: rig.rays().kept,
        rays_traced_again: again / u64::from(moves),
    })
}

/// The scene as baked, under the light of a look.
fn lit(baked: &Baked, look: &Look) -> Situation {
    let mut situation = Situation::unlit(baked);
    situation.appearance = look.appearance.clone().into();
    situation.lights = look.lights.clone();
    if look.components.environment {
        let mut rig = LightRig::new(&baked.dataset.tree);
        situation.environment = Some(rig.lighting(&look.illumination, look.illum_cut).into());
        situation.suns = look.illumination.suns().into();
    }
    situation
}

/// Times of a solution.
struct Solved {
    first: Duration,
    all: Duration,
    bounces: u32,
}

impl Solved {
    /// Solves, with the light after each bounce as it is shown.
    fn by(rig: &mut RadiosityRig, start: Instant) -> Self {
        let mut times = Vec::new();
        loop {
            let step = rig.step();
            if step != RadiosityStep::Partial {
                rig.shown();
                times.push(start.elapsed());
            }
            if step == RadiosityStep::Last {
                return Self { first: times[0], all: times[times.len() - 1], bounces: times.len() as u32 };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::test_scenes::dataset;
    use lapidary_render::{Appearance, test_looks::look};

    #[test]
    fn a_dataset_without_functions_is_told() {
        let baked = Baked::from(dataset(&["a"], &[]));
        let look = Look { appearance: Appearance::of(&baked.dataset.scene), ..look() };
        let error = measured(&baked, &look, "a", &Poses::default(), 1).unwrap_err().to_string();
        assert!(error.contains("--mode radiosity"), "{error}");
    }
}
