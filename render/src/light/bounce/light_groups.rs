//! Groups of lights with stored irradiance at some points, so that an edit casts rays only for changed lights. The first edit of a
//! light casts rays for all lights of its group. Edited lights then have groups of their own.

use crate::light::light_counts::{LightCounts, LightKey, light_key};
use glam::Vec3;
use lapidary_core::lights::Light;
use std::collections::HashSet;

/// Largest number of groups; each takes 12 bytes per point.
pub(super) const LIGHT_GROUPS: usize = 64;

/// Most groups of edited lights.
const EDITED_GROUPS: usize = LIGHT_GROUPS / 2;

/// Some lights and their joint irradiance at each point, visibility included.
pub(super) struct LightGroup {
    lights: Vec<Light>,
    pub(super) irradiance: Vec<Vec3>,
}

impl LightGroup {
    /// Its lights.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    fn keys(&self) -> Vec<LightKey> {
        self.lights.iter().map(light_key).collect()
    }
}

/// All lights that are switched on.
#[derive(Default)]
pub(super) struct LightGroups {
    pub(super) groups: Vec<LightGroup>,
}

impl LightGroups {
    /// Replaces the lights; `cast` computes the joint irradiance of a few.
    pub fn update(&mut self, lights: &[Light], cast: impl Fn(&[Light]) -> Vec<Vec3>) {
        let on: Vec<&Light> = lights.iter().filter(|light| light.enabled).collect();
        let mut wanted = LightCounts::of(on.iter().copied());
        let (kept, broken): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.groups).into_iter().partition(|group| wanted.take(&group.keys()));
        let known: HashSet<LightKey> = broken.iter().flat_map(LightGroup::keys).collect();
        let left = on.into_iter().filter(|light| wanted.take(&[light_key(light)])).cloned();
        let (unchanged, edited): (Vec<Light>, Vec<Light>) = left.partition(|light| known.contains(&light_key(light)));
        let grouped = |lights: &[Light], count: usize| -> Vec<LightGroup> {
            let chunks = lights.chunks(lights.len().div_ceil(count).max(1));
            chunks.map(|l| LightGroup { lights: l.to_vec(), irradiance: cast(l) }).collect()
        };
        self.groups = kept;
        self.groups.extend(grouped(&unchanged, EDITED_GROUPS));
        let room = LIGHT_GROUPS - self.groups.len().min(EDITED_GROUPS);
        let edited = grouped(&edited, room);
        self.merge_down_to(LIGHT_GROUPS - edited.len());
        self.groups.extend(edited);
    }

    /// Adds up the irradiance of the smallest groups until at most `most` groups are left.
    fn merge_down_to(&mut self, most: usize) {
        let most = most.max(1);
        if self.groups.len() <= most {
            return;
        }
        self.groups.sort_by_key(|group| std::cmp::Reverse(group.lights.len()));
        for small in self.groups.split_off(most) {
            let into = &mut self.groups[most - 1];
            into.lights.extend(small.lights);
            into.irradiance.iter_mut().zip(small.irradiance).for_each(|(sum, part)| *sum += part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::point_light;
    use std::cell::Cell;

    /// Irradiance of a point from lights that each give it their x and a count of one.
    fn irradiance(lights: &[Light]) -> Vec<Vec3> {
        vec![lights.iter().map(|l| Vec3::new(l.position.x, 1.0, 0.0)).sum()]
    }

    fn lamps(count: usize) -> Vec<Light> {
        (0..count).map(|i| point_light(Vec3::new(i as f32, 0.0, 0.0), 1.0)).collect()
    }

    /// Groups that count the lights that cast rays at each update.
    #[derive(Default)]
    struct Counted {
        groups: LightGroups,
        last: Cell<usize>,
    }

    impl Counted {
        fn update(&mut self, lights: &[Light]) -> usize {
            let Self { groups, last, .. } = self;
            last.set(0);
            groups.update(lights, |part| {
                last.set(last.get() + part.len());
                irradiance(part)
            });
            let sum = groups.groups.iter().map(|group| group.irradiance[0]).sum::<Vec3>();
            let on: Vec<Light> = lights.iter().filter(|l| l.enabled).cloned().collect();
            assert_eq!(sum, irradiance(&on).first().copied().unwrap_or_default(), "however many were cast again");
            assert!(groups.groups.len() <= LIGHT_GROUPS);
            last.get()
        }
    }

    #[test]
    fn of_thousands_a_moved_light_casts_rays_with_its_group_once_and_then_alone() {
        let mut lights = lamps(2000);
        let mut counted = Counted::default();
        assert_eq!(counted.update(&lights), 2000);
        assert_eq!(counted.update(&lights), 0, "nothing has changed");
        for (step, most) in [(0, 2000_usize.div_ceil(LIGHT_GROUPS)), (1, 1), (2, 1)] {
            lights[700].position.y = 1.0 + step as f32;
            let cast = counted.update(&lights);
            assert!(cast > 0 && cast <= most, "step {step}: {cast}");
        }
        lights[700].enabled = false;
        assert_eq!(counted.update(&lights), 0, "the edited light has its own group");
        lights.remove(3);
        assert!(counted.update(&lights) <= 64, "the lights after a removed one are unchanged");
        lights.insert(0, point_light(Vec3::splat(0.5), 1.0));
        assert_eq!(counted.update(&lights), 1);
        lights[5].name = "renamed".into();
        assert_eq!(counted.update(&lights), 0);
    }

    #[test]
    fn many_edits_in_any_order_keep_the_sum_and_the_number_of_groups() {
        let mut random = fastrand::Rng::with_seed(11);
        let mut lights = lamps(300);
        let (mut counted, mut cast) = (Counted::default(), 0);
        counted.update(&lights);
        for _ in 0..200 {
            let i = random.usize(..lights.len());
            match random.u32(..4) {
                0 => lights[i].enabled = !lights[i].enabled,
                1 => lights.push(lights[i].clone()),
                2 => drop(lights.swap_remove(i)),
                _ => lights[i].position.x = random.u32(..1000) as f32,
            }
            cast += counted.update(&lights);
        }
        assert!(cast < 200 * 60, "{cast}, where all lights each time are 60,000");
        lights.iter_mut().for_each(|light| light.intensity *= 2.0);
        assert!(counted.update(&lights) > 100, "negative control: all lights changed");
        assert_eq!((counted.update(&[]), counted.groups.groups.len()), (0, 0));
    }
}
