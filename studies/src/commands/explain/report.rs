//! Text output of `explain`.

use glam::Vec3;
use lapidary_core::color::luminance;
use lapidary_render::{ErrorSplit, PixelExplanation, SplitStep};
use std::fmt::Write;

/// Number of listed nodes.
const LISTED: usize = 10;

/// The vertices, and the nodes with the largest contributions.
pub fn of_pixel(explanation: &PixelExplanation) -> String {
    let PixelExplanation { pixel: [x, y], position, radiance, nodes, vertices, .. } = explanation;
    let sizes = vertices.map(|vertex| {
        let lit = vertex.lit_nodes.map_or(String::new(), |nodes| format!(", lit {nodes}"));
        format!("{} (weight {:.2}{lit})", vertex.cut_nodes, vertex.weight)
    });
    let mut text = format!(
        "pixel {x},{y} at {position:.3}: radiance {:.4}, {:.4}, {:.4}\n\
         cuts of its vertices: {}; illumination cut {}; merged {}, of which {} see no light; {} terms with BRDF refinement\n\
         \x20  share      node depth       sr  visibility  radiance  BRDF*cos\n",
        radiance.x,
        radiance.y,
        radiance.z,
        sizes.join(", "),
        explanation.illumination_nodes,
        explanation.merged_nodes,
        explanation.dark_nodes.len(),
        nodes.len(),
    );
    let whole = luminance(*radiance).max(f32::MIN_POSITIVE);
    for &i in explanation.by_contribution().iter().take(LISTED) {
        let node = &nodes[i];
        let share = 100.0 * luminance(node.contribution) / whole;
        let (radiance, brdf_cos) = (luminance(node.radiance), luminance(node.brdf_cos));
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{share:6.2} % {:9} {:5} {:8.5} {:11.3} {radiance:9.4} {brdf_cos:9.4}",
            node.heap_index, node.depth, node.solid_angle, node.visibility
        );
    }
    for sun in &explanation.suns {
        let share = 100.0 * luminance(sun.contribution) / whole;
        let _ = writeln!(text, "{share:6.2} % a sun of {:.1} degrees, by rays", sun.angle_degrees);
    }
    if explanation.mirror != Vec3::ZERO {
        let share = 100.0 * luminance(explanation.mirror) / whole;
        let _ = writeln!(text, "{share:6.2} % by a mirror, which reads the map in place of nodes");
    }
    if explanation.has_rays {
        text += "a mirror: rays of the picture show the scene in place of this light around the mirror direction\n";
    }
    text.truncate(text.trim_end().len());
    text
}

/// The steps of the error and the total.
pub fn of_split(split: &ErrorSplit) -> String {
    let region = split.region;
    let mut text = format!(
        "error of {} x {} pixels from {},{} against {} light paths per pixel\n\
         factor                 rel. RMSE     FLIP   from -> to\n",
        region.width, region.height, region.x, region.y, split.spp
    );
    for step in split.steps.iter().chain([&split.total]) {
        text += &line(step);
    }
    text.truncate(text.trim_end().len());
    text
}

fn line(step: &SplitStep) -> String {
    let noise = if step.noise > 0.0 { format!(" (noise {:.4})", step.noise) } else { String::new() };
    let SplitStep { factor, rel_rmse, flip, from, to, .. } = step;
    format!("{factor:<22} {rel_rmse:9.4} {flip:8.4}   {} -> {}{noise}\n", from.name(), to.name())
}
