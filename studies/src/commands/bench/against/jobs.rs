//! Scenes, bakes, and the table of jobs whose figures are rows of the report.

use serde_json::Value;

/// A bundled scene.
pub struct Scene {
    /// Name in the report.
    pub name: &'static str,
    /// Name of folder and file; `bench --suite` of older programs prefixes its figures with it.
    pub file: &'static str,
    /// Baked parts, as for `bake --mode`.
    pub mode: &'static str,
}

const STILL_LIFE: usize = 0;
const INTERIOR: usize = 1;
const COLOR_BOX: usize = 2;

/// All scenes.
pub const SCENES: [Scene; 3] = [
    Scene { name: "still life", file: "still-life", mode: "environment" },
    Scene { name: "interior", file: "interior", mode: "cuts" },
    Scene { name: "color box", file: "color-box", mode: "all" },
];

/// Work of a program in one run.
pub enum Work {
    /// Bakes the scene; the whole process is timed.
    Bake,
    /// Measures frames, drags or edits of the dataset on the CPU: `bench` with these groups of options. `{maps}` is replaced by the
    /// folder of environments.
    Bench(&'static [&'static [&'static str]]),
    /// The same measurement on a graphics adapter.
    Adapter(&'static [&'static [&'static str]]),
    /// Opens the window on the dataset and times its first picture.
    Window,
}

/// Alternating runs of both programs.
pub struct Job {
    /// Index in [`SCENES`].
    pub scene: usize,
    /// Work of each run.
    pub work: Work,
    /// Option of `bench`, or value of one, that a program must have for this job.
    pub needs: Option<&'static str>,
    /// Rounds of runs.
    pub rounds: usize,
    /// Whether each program also runs on the other's dataset.
    pub is_crossed: bool,
    /// Figures in its rows.
    pub figures: &'static [Figure],
}

/// One row of the report.
pub struct Figure {
    /// Measured quantity, after the scene.
    pub name: &'static str,
    /// Places in a run's JSON, in milliseconds: keys and indices, or `last`. Several are added up.
    places: &'static [&'static str],
    /// Name in `bench --suite` of programs without `--edits`.
    in_suite: Option<&'static str>,
}

impl Job {
    /// Name of a row.
    pub fn name_of(&self, figure: &Figure) -> String {
        format!("{}: {}", SCENES[self.scene].name, figure.name)
    }

    /// Figures from the output of `bench --suite`.
    pub fn in_suite(&self, suite: &Value) -> Vec<Option<f64>> {
        self.figures.iter().map(|figure| figure.of_suite(SCENES[self.scene].file, suite)).collect()
    }
}

impl Figure {
    /// Milliseconds from the output of a run.
    pub fn of(&self, printed: &Value) -> Option<f64> {
        self.places.iter().map(|place| at(printed, place)?.as_f64()).sum()
    }

    fn of_suite(&self, scene: &str, suite: &Value) -> Option<f64> {
        let name = format!("{scene}: {}", self.in_suite?);
        let figures = suite.get("figures")?.as_array()?;
        figures.iter().find(|figure| figure["name"] == *name)?.get("milliseconds")?.as_f64()
    }
}

fn at<'a>(value: &'a Value, place: &str) -> Option<&'a Value> {
    place.split('/').try_fold(value, |value, key| match value {
        Value::Array(values) if key == "last" => values.last(),
        Value::Array(values) => values.get(key.parse::<usize>().ok()?),
        value => value.get(key),
    })
}

const fn figure(name: &'static str, places: &'static [&'static str]) -> Figure {
    Figure { name, places, in_suite: None }
}

const fn in_suite(name: &'static str, places: &'static [&'static str], known_as: &'static str) -> Figure {
    Figure { in_suite: Some(known_as), ..figure(name, places) }
}

const TOTAL: &[&str] = &["runs/0/milliseconds/total"];
const ROTATION: &[&str] = &["rotation_milliseconds"];
const LIGHT_MOVED: &[&str] = &["light_moved_milliseconds"];
const COARSEST: &[&str] = &["details/0/light_milliseconds", "details/0/sketch_milliseconds"];
const FINEST: &[&str] = &["details/last/light_milliseconds", "details/last/sketch_milliseconds"];

/// Common options of all `bench` runs.
pub const COMMON: [&str; 2] = ["--frames", "3"];

const SMALL: &[&str] = &["--size", "320x240"];
const LARGE: &[&str] = &["--size", "640x480"];
const STUDIO: &[&str] = &["--env", "{maps}/studio.hdr", "--components", "environment"];
const DAY: &[&str] = &["--env", "{maps}/sun-and-sky.hdr"];
const SPOT: &[&str] = &["--env", "none", "--components", "direct,indirect"];
const NO_SUN: &[&str] = &["--sun", "off"];
const NO_LAMPS: &[&str] = &["--components", "environment"];
const LAMPS: &[&str] = &["--components", "environment,direct"];
const LAMPS_AND_BOUNCE: &[&str] = &["--components", "environment,direct,indirect"];
const CUTS: &[&str] = &["--solution", "cuts"];
const MESHLESS: &[&str] = &["--solution", "meshless"];
const BOTH: &[&str] = &["--solution", "cuts+meshless"];
const GLOSS: &[&str] = &["--solution", "cuts+gloss"];

const fn job(scene: usize, work: Work, figures: &'static [Figure]) -> Job {
    Job { scene, work, needs: None, rounds: 1, is_crossed: false, figures }
}

const fn frames(scene: usize, options: &'static [&'static [&'static str]], figures: &'static [Figure]) -> Job {
    Job { rounds: 2, is_crossed: true, ..job(scene, Work::Bench(options), figures) }
}

const fn drag(scene: usize, options: &'static [&'static [&'static str]]) -> Job {
    const DRAG: &[Figure] = &[figure("drag, coarsest detail", COARSEST), figure("drag, finest detail", FINEST)];
    Job { rounds: 2, needs: Some("--drag"), ..job(scene, Work::Bench(options), DRAG) }
}

const fn edits(scene: usize, options: &'static [&'static [&'static str]], figures: &'static [Figure]) -> Job {
    Job { rounds: 2, needs: Some(EDITS), ..job(scene, Work::Bench(options), figures) }
}

/// The option whose figures `bench --suite` of older programs includes.
pub const EDITS: &str = "--edits";

const EDIT: Figure = in_suite("edit, first sketch", &["edit/sketch_milliseconds"], "drag, first sketch");
const EDITED: Figure = in_suite("edit, finished", &["edit/finished_milliseconds"], "drag, finished");
const ORBIT: Figure = in_suite("orbit, first sketch", &["orbit/sketch_milliseconds"], "orbit, first sketch");
const ORBITED: Figure = in_suite("orbit, finished", &["orbit/finished_milliseconds"], "orbit, finished");
const TURN: Figure = in_suite("turn, light", &["turned/light_milliseconds"], "rotation, light");
const TURNED: Figure = in_suite("turn, finished", &["turned/finished_milliseconds"], "rotation, finished");

/// All jobs. Bakes come first, because the others use their datasets. Edits are without suns, as in the suite of older programs.
#[rustfmt::skip]
pub const JOBS: &[Job] = &[
    job(STILL_LIFE, Work::Bake, &[figure("bake", &[])]),
    job(INTERIOR, Work::Bake, &[figure("bake", &[])]),
    job(COLOR_BOX, Work::Bake, &[figure("bake", &[])]),
    frames(STILL_LIFE, &[SMALL, STUDIO], &[figure("frame, studio", TOTAL), figure("studio turned", ROTATION)]),
    frames(STILL_LIFE, &[SMALL, DAY, NO_LAMPS, NO_SUN], &[figure("frame, day without sun", TOTAL)]),
    frames(STILL_LIFE, &[SMALL, DAY, NO_LAMPS], &[figure("frame, day", TOTAL), figure("day turned", ROTATION)]),
    frames(INTERIOR, &[SMALL, DAY, LAMPS], &[figure("frame, direct", TOTAL)]),
    frames(INTERIOR, &[SMALL, DAY, LAMPS_AND_BOUNCE, CUTS], &[figure("frame, cuts", TOTAL), figure("light moved, cuts", LIGHT_MOVED)]),
    frames(COLOR_BOX, &[SMALL, SPOT, CUTS], &[figure("frame, cuts", TOTAL), figure("light moved, cuts", LIGHT_MOVED)]),
    frames(COLOR_BOX, &[SMALL, SPOT, MESHLESS], &[figure("frame, meshless", TOTAL), figure("light moved, meshless", LIGHT_MOVED)]),
    frames(COLOR_BOX, &[SMALL, SPOT, BOTH], &[figure("frame, cuts+meshless", TOTAL), figure("light moved, cuts+meshless", LIGHT_MOVED)]),
    Job { needs: Some(GLOSS[1]), ..frames(COLOR_BOX, &[SMALL, SPOT, GLOSS], &[figure("frame, cuts+gloss", TOTAL), figure("light moved, cuts+gloss", LIGHT_MOVED)]) },
    job(STILL_LIFE, Work::Adapter(&[SMALL, STUDIO]), &[figure("frame, studio, adapter", TOTAL)]),
    Job { rounds: 3, ..job(STILL_LIFE, Work::Window, &[figure("first picture in the window", &[])]) },
    drag(COLOR_BOX, &[SMALL, SPOT, CUTS, &["--drag", "Short block"]]),
    drag(INTERIOR, &[SMALL, DAY, LAMPS_AND_BOUNCE, CUTS, &["--drag", "Box lid"]]),
    edits(STILL_LIFE, &[LARGE, STUDIO, NO_SUN, &[EDITS, "Copper"]], &[EDIT, EDITED, ORBIT, ORBITED, TURN, TURNED]),
    edits(INTERIOR, &[LARGE, DAY, NO_SUN, LAMPS_AND_BOUNCE, CUTS, &[EDITS, "Upholstery"]], &[EDIT, EDITED, ORBIT, ORBITED, TURN, TURNED]),
    edits(COLOR_BOX, &[LARGE, SPOT, CUTS, &[EDITS, "Red paint"]], &[EDIT, EDITED, ORBIT, ORBITED]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn figures_are_found_in_what_runs_and_suites_print() {
        let details =
            json!({"details": [{"light_milliseconds": 1.0, "sketch_milliseconds": 2.5}, {"light_milliseconds": 7.0}]});
        assert_eq!(figure("a", COARSEST).of(&details), Some(3.5));
        assert_eq!(figure("a", FINEST).of(&details), None, "the last one has no sketch");
        assert_eq!(figure("a", TOTAL).of(&json!({"runs": []})), None);
        let suite = json!({"figures": [{"name": "color-box: drag, finished", "milliseconds": 8.0}]});
        let of_suite = |scene: usize| edits(scene, &[], &[EDITED, ORBITED]).in_suite(&suite);
        assert_eq!(of_suite(COLOR_BOX), [Some(8.0), None]);
        assert_eq!(of_suite(INTERIOR), [None, None], "negative control");
    }

    #[test]
    fn no_two_rows_have_one_name() {
        let names = || JOBS.iter().flat_map(|job| job.figures.iter().map(|figure| job.name_of(figure)));
        assert_eq!(names().collect::<std::collections::BTreeSet<_>>().len(), names().count());
    }
}
