//! What the suite found, as JSON and as a table.

use super::super::drag::Detailed;
use lapidary_render::gpu::{AdapterFacts, GpuPath};
use serde::Serialize;
use std::{collections::BTreeMap, fmt::Write, time::Duration};

/// All figures.
#[derive(Debug, Serialize)]
pub struct Suite {
    pub adapter: AdapterFacts,
    /// As it is measured at the first start.
    pub faster_path: GpuPath,
    /// Of the pictures whose passes are timed.
    pub size: [u32; 2],
    pub bakes: Vec<Bake>,
    pub pictures: Vec<Picture>,
    pub drags: Vec<Drag>,
    pub compiled: Vec<Compiled>,
    /// Of the whole suite.
    pub seconds: f64,
}

/// A draft bake.
#[derive(Debug, Serialize)]
pub struct Bake {
    pub scene: &'static str,
    pub device: &'static str,
    pub seconds: f64,
    pub rays: u64,
}

/// A picture by one path.
#[derive(Debug, Serialize)]
pub struct Picture {
    pub name: String,
    pub path: GpuPath,
    /// Median times by pass, and `total`.
    pub milliseconds: BTreeMap<&'static str, f64>,
    pub difference: Difference,
    /// Bytes on the adapter with it, if its interface tells.
    pub allocated_bytes: Option<u64>,
}

/// From the picture of the CPU.
#[derive(Debug, Serialize)]
pub struct Difference {
    /// Relative root mean squared error.
    pub relative: f64,
    pub flip: f64,
}

/// An object that is dragged.
#[derive(Debug, Serialize)]
pub struct Drag {
    pub name: String,
    pub object: String,
    /// By the coarsest and the finest detail.
    pub details: Vec<Detailed>,
}

/// What the passes of a picture took to compile, where the driver did not know them from before.
#[derive(Debug, Serialize)]
pub struct Compiled {
    pub name: String,
    pub path: GpuPath,
    /// By the label of the pass, in the order of compilation.
    pub milliseconds: Vec<(&'static str, f64)>,
}

impl Compiled {
    pub fn new(name: String, path: GpuPath, times: &[(&'static str, Duration)]) -> Self {
        let milliseconds = times.iter().map(|&(pass, time)| (pass, 1e3 * time.as_secs_f64())).collect();
        Self { name, path, milliseconds }
    }
}

impl Suite {
    pub fn table(&self) -> String {
        self.written().expect("a string takes all")
    }

    fn written(&self) -> Result<String, std::fmt::Error> {
        let (mut text, AdapterFacts { name, kind, driver, interface, .. }) = (String::new(), &self.adapter);
        let [width, height] = self.size;
        writeln!(text, "{name} ({kind}), {driver}, {interface}; {width} x {height}; {:.0} s", self.seconds)?;
        writeln!(text, "the faster path is {}", label(self.faster_path))?;
        for Bake { scene, device, seconds, rays } in &self.bakes {
            writeln!(text, "bake, {scene}, {device}: {seconds:.1} s, {:.0} million rays", 1e-6 * *rays as f64)?;
        }
        for Picture { name, path, milliseconds, difference, allocated_bytes } in &self.pictures {
            let passes: Vec<String> = milliseconds.iter().map(|(name, ms)| format!("{name} {ms:.2}")).collect();
            let Difference { relative, flip } = difference;
            let (path, passes) = (label(*path), passes.join(", "));
            let memory = allocated_bytes.map_or(String::new(), |bytes| format!("; {} MiB", bytes >> 20));
            writeln!(text, "{name}, {path}: {passes} ms; from the CPU's {relative:.4}, FLIP {flip:.4}{memory}")?;
        }
        for Drag { name, object, details } in &self.drags {
            writeln!(text, "{name}, \"{object}\" dragged:")?;
            details.iter().for_each(|detail| text += &detail.line());
        }
        for Compiled { name, path, milliseconds } in &self.compiled {
            let all: f64 = milliseconds.iter().map(|(_, ms)| ms).sum();
            let (longest, most) = milliseconds.iter().max_by(|a, b| a.1.total_cmp(&b.1)).ok_or(std::fmt::Error)?;
            let path = label(*path);
            writeln!(text, "compiled, {name}, {path}: {all:.0} ms, of which {longest} {most:.0}")?;
        }
        Ok(text)
    }
}

fn label(path: GpuPath) -> &'static str {
    match path {
        GpuPath::Fragment => "fragment",
        GpuPath::Compute => "compute",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_a_line_for_each_figure() {
        let suite = Suite {
            adapter: AdapterFacts {
                name: "a card".into(),
                kind: "DiscreteGpu".into(),
                driver: "driver 1".into(),
                interface: "vulkan".into(),
                max_storage_bytes: 1,
                max_texture_side: 1,
            },
            faster_path: GpuPath::Compute,
            size: [4, 3],
            bakes: vec![Bake { scene: "room", device: "gpu", seconds: 1.5, rays: 2_000_000 }],
            pictures: vec![Picture {
                name: "room: day".into(),
                path: GpuPath::Fragment,
                milliseconds: BTreeMap::from([("total", 2.0)]),
                difference: Difference { relative: 0.001, flip: 0.002 },
                allocated_bytes: Some(3 << 20),
            }],
            drags: Vec::new(),
            compiled: vec![Compiled::new(
                "room".into(),
                GpuPath::Compute,
                &[("a", Duration::from_millis(3)), ("b", Duration::from_millis(4))],
            )],
            seconds: 9.0,
        };
        let lines = [
            "a card (DiscreteGpu), driver 1, vulkan; 4 x 3; 9 s",
            "the faster path is compute",
            "bake, room, gpu: 1.5 s, 2 million rays",
            "room: day, fragment: total 2.00 ms; from the CPU's 0.0010, FLIP 0.0020; 3 MiB",
            "compiled, room, compute: 7 ms, of which b 4",
        ];
        assert_eq!(suite.table().lines().collect::<Vec<_>>(), lines);
    }
}
