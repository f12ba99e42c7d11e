//! The demonstration's report as one page.

use super::{
    Picture, Report,
    ladder::{CUT_SIZES, MAP_TOP, PATH_SAMPLES, Rung},
};
use crate::report::{
    self,
    chart::{Chart, Line, Scale, histogram},
    text::{escaped, grouped, megabytes, seconds},
};
use lapidary_render::compare::Metrics;

/// The whole page.
pub fn page(report: &Report) -> String {
    let sections = [
        hero(report),
        key_figures(report),
        ladder(report),
        refinement(report),
        error_maps(report),
        gallery(report),
        bake(report),
        footer(report),
    ];
    let head = format!("lapidary demo, version {}, {} threads", report.version, report.threads);
    report::page("demonstration", &head, &sections)
}

fn figure(class: &str, picture: &Picture, caption: &str) -> String {
    report::figure(class, &picture.png, picture.settings.size, &picture.title, caption)
}

fn hero(report: &Report) -> String {
    let picture = &report.gallery.hero;
    let caption = format!(
        "Lit by the whole environment “{}” through an illumination cut of {} nodes, in {} on the CPU with {} samples a \
         pixel. No pixel is noisy: which lights each vertex sees was found once, in the bake.",
        picture.settings.environment,
        picture.settings.illum_cut,
        seconds(picture.seconds),
        picture.settings.aa,
    );
    figure("hero", picture, &caption)
        + "<div><h1>One bake, then any light and any material, free of noise</h1>\
           <p>Each vertex keeps a <em>visibility cut</em>: a coarse partition of the sky into clusters of directions, \
           each seen or blocked to a known degree, fine only where shadows need it. An environment becomes an \
           <em>illumination cut</em> over the same tree. A pixel walks both in one pass, and evaluates the material \
           where they meet.</p></div>"
}

fn key_figures(report: &Report) -> String {
    let best = &report.ladder.refined[CUT_SIZES.len() - 1];
    let environment = &report.gallery.environments[0];
    let samples = u64::from(environment.settings.size[0]) * u64::from(environment.settings.size[1]);
    let milliseconds = 1e6 * environment.seconds / (samples * u64::from(environment.settings.aa)) as f64;
    let figure = |value: String, unit: &str, text: &str| {
        format!("<div><b>{value}<small>{unit}</small></b><span>{text}</span></div>")
    };
    let figures = [
        figure(format!("{:.0}", report.bake.seconds.get("total").unwrap_or(&0.0)), "s", "to bake the scene, once"),
        figure(
            format!("{:.0}", report.bake.mean_cut),
            "nodes",
            &format!("in a cut, for {} light samples", grouped(report.bake.lights as u64)),
        ),
        figure(
            format!("{:.1}", report.bake.bytes_cuts as f64 / 1e6),
            "MB",
            &format!("of cuts for {} vertices", grouped(report.bake.vertices as u64)),
        ),
        figure(format!("{milliseconds:.1}"), "µs", "for a pixel’s sample"),
        figure(format!("{:.3}", best.metrics.flip), "FLIP", "difference from ray tracing, 0 to 1"),
        figure(format!("{:.0}", report.seconds), "s", "for all of this page"),
    ];
    format!("<div class=\"key\">{}</div>", figures.concat())
}

fn ladder(report: &Report) -> String {
    let ladder = &report.ladder;
    let rungs: String = ladder.refined.iter().map(|rung| figure("", &rung.picture, &rung_caption(rung))).collect();
    let truth = format!(
        "<b>Ray-traced reference</b>{} light samples<br>at every pixel<br>{}",
        grouped(report.bake.lights as u64),
        seconds(ladder.samples_reference.seconds)
    );
    let chart = |title, metric: fn(&Metrics) -> f64| {
        let line = |name: &str, rungs: &[Rung]| Line {
            name: name.into(),
            points: rungs.iter().map(|r| (r.picture.settings.illum_cut.into(), metric(&r.metrics))).collect(),
        };
        let lines = [line("refined", &ladder.refined), line("once", &ladder.once)];
        Chart { title, x_label: "nodes of the illumination cut", x: Scale::Log, y: Scale::Linear, lines: &lines }.svg()
    };
    format!(
        "<section><h2>More nodes, less error</h2>\
         <p>The illumination cut is the budget of a picture. It starts with the clusters whose radiance varies too much \
         and spends what is left on the brightest. The reference uses the same light samples but traces every shadow ray \
         at every pixel, so the difference is what the cuts cost.</p>\
         <div class=\"grid six\">{rungs}{}</div>\
         <div class=\"grid two\">{}{}</div></section>",
        figure("truth", &ladder.samples_reference, &truth),
        chart("Relative RMSE", |m| m.rel_rmse),
        chart("FLIP", |m| m.flip),
    )
}

fn rung_caption(rung: &Rung) -> String {
    format!(
        "<b>{} nodes</b>relative RMSE {:.3}<br>FLIP {:.3}, SSIM {:.3}<br>{}",
        rung.picture.settings.illum_cut,
        rung.metrics.rel_rmse,
        rung.metrics.flip,
        rung.metrics.ssim,
        seconds(rung.picture.seconds)
    )
}

fn refinement(report: &Report) -> String {
    let detail = &report.ladder.detail;
    let caption = |name: &str, picture: &Picture, metrics: &Metrics| {
        let evaluations = picture.stats.as_ref().map_or(0.0, |s| s.mean_brdf_evaluations);
        format!(
            "<b>{name}</b>{evaluations:.0} BRDF evaluations a pixel, {}<br>relative RMSE {:.3}, FLIP {:.3}",
            seconds(picture.seconds),
            metrics.rel_rmse,
            metrics.flip
        )
    };
    let truth = format!(
        "<b>Path-traced reference</b>{} at {PATH_SAMPLES} samples a pixel; no cuts;<br>its noise is part of the errors here",
        seconds(detail.path_reference.seconds)
    );
    format!(
        "<section><h2>Glossy materials: refine where the lobe is narrow</h2>\
         <p>Sampling the material once for each node, as the paper did, makes blotches where a cluster is wider than the \
         highlight. The merge can halve such nodes as it meets them, with nothing precomputed and few more evaluations. \
         Both pictures have an illumination cut of {} nodes.</p>\
         <div class=\"grid three\">{}{}{}</div></section>",
        detail.once.settings.illum_cut,
        figure("", &detail.once, &caption("Once a node", &detail.once, &detail.metrics_once)),
        figure("", &detail.refined, &caption("Refined", &detail.refined, &detail.metrics_refined)),
        figure("truth", &detail.path_reference, &truth),
    )
}

fn error_maps(report: &Report) -> String {
    let map = |rung: &Rung| {
        format!(
            "<figure class=\"map\"><a href=\"{0}\"><img src=\"{0}\" alt=\"Error map\"></a><figcaption>{1} nodes: {2:.3}</figcaption></figure>",
            rung.error_map, rung.picture.settings.illum_cut, rung.metrics.rel_rmse
        )
    };
    let row = |rungs: &[Rung]| rungs.iter().map(map).collect::<String>();
    format!(
        "<section><h2>Where the error is</h2>\
         <p>Relative error of each pixel against the ray-traced reference. With refinement it is left where shadows \
         fall between vertices, and does not depend on the light’s budget; without, it also sits in every highlight.</p>\
         <div class=\"legend\">0<i></i>{MAP_TOP} and above</div>\
         <h3>Refined</h3><div class=\"grid five\">{}</div><h3>Once a node</h3><div class=\"grid five\">{}</div></section>",
        row(&report.ladder.refined),
        row(&report.ladder.once),
    )
}

fn gallery(report: &Report) -> String {
    let row = |pictures: &[Picture]| {
        let one = |p: &Picture| figure("", p, &format!("<b>{}</b>{}", capitalized(&p.title), seconds(p.seconds)));
        format!("<div class=\"grid three\">{}</div>", pictures.iter().map(one).collect::<String>())
    };
    format!(
        "<section><h2>Any environment</h2><p>The bake knows nothing of light: a new environment only needs a new \
         illumination cut, whose making is part of the times below.</p>{}</section>\
         <section><h2>Any rotation</h2><p>“{}” turned about the vertical. Energy is conserved at every angle.</p>{}</section>\
         <section><h2>Any material</h2><p>Materials enter at the pixel, so they too are free to change. Here the whole \
         scene takes one.</p>{}</section>",
        row(&report.gallery.environments),
        capitalized(&report.gallery.rotations[0].settings.environment.replace('-', " ")),
        row(&report.gallery.rotations),
        row(&report.gallery.materials),
    )
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

fn bake(report: &Report) -> String {
    let b = &report.bake;
    let warnings: String = b.warnings.iter().map(|w| format!("<p>Warning: {}</p>", escaped(w))).collect();
    format!(
        "<section><h2>The bake</h2><p>Cuts are split until each cluster’s error is below a bound (sigma {:.1}), so their \
         size follows the scene: open places need few nodes, the lantern’s filigree many. A cut of one node sees \
         everything or nothing.</p>{warnings}\
         <div class=\"grid two\"><div><table>{}</table></div><div>{}<table>{}</table></div></div></section>",
        b.sigma,
        bake_contents(report),
        histogram(&b.cut_size_histogram),
        bake_times(report),
    )
}

fn row(name: &str, value: &str, text: &str) -> String {
    format!("<tr><td>{name}</td><td>{value}</td><td>{text}</td></tr>")
}

fn bake_contents(report: &Report) -> String {
    let (b, v) = (&report.bake, &report.verification);
    let added = grouped((b.vertices - b.source_vertices) as u64);
    let rows = [
        row("Vertices", &grouped(b.vertices as u64), &format!("{added} of them added where shadows need them")),
        row("Triangles", &grouped(b.triangles as u64), "after tessellation"),
        row("Light samples", &grouped(b.lights as u64), "directions, even over the sphere: leaves of the light tree"),
        row("Nodes a cut", &format!("{:.1}", b.mean_cut), &format!("on average, {} at most; 16 bits each", b.max_cut)),
        row("Visibility RMS", &format!("{:.3}", b.rms_visibility), "stored against traced, over vertices and lights"),
        row("Cuts", &megabytes(b.bytes_cuts), &format!("of {} for the whole dataset", megabytes(b.bytes_total))),
        row("Pairs", &format!("{:.0} M", b.samples_resolved as f64 / 1e6), "of vertex and light"),
        row("Buried points", &grouped(b.buried_points as u64), "lie inside other geometry and have no say"),
        row(
            "Traced again",
            &grouped(v.vertices as u64),
            &format!("vertices, ray by ray; {} cuts differ", v.different_cuts),
        ),
    ];
    rows.concat()
}

fn bake_times(report: &Report) -> String {
    let b = &report.bake;
    let phase = |name: &str| seconds(*b.seconds.get(name).unwrap_or(&0.0));
    let speed = format!("all pairs traced, {:.1} million a second, and cuts selected", b.samples_per_second / 1e6);
    let rows = [
        row("Tessellation", &phase("tessellate"), "edges split where visibility bends between their ends"),
        row("Pilot", &phase("pilot"), "visibility of a few vertices, to cluster the lights by"),
        row("Light tree", &phase("tree"), "lights clustered by direction and pilot visibility"),
        row("Visibility", &phase("visibility"), &speed),
        row("Whole bake", &phase("total"), &format!("{} of memory at most", megabytes(b.peak_memory_bytes))),
    ];
    rows.concat()
}

fn footer(report: &Report) -> String {
    format!(
        "<section><h2>Go on from here</h2><p>All figures are in <a href=\"report.json\">report.json</a>; every picture \
         lies beside this page as PNG and as scene-linear EXR. The dataset is <code>still-life.cuts</code>: relight it \
         without baking again.</p><pre><code>lapidary render still-life.cuts --env sun-sky:20 --rotate 40 --out evening.png\n\
         lapidary render still-life.cuts --env studio --camera detail --roughness 0.2 --metalness 1 --out steel.png\n\
         lapidary compare {} {}</code></pre></section>",
        report.ladder.refined[0].picture.exr, report.ladder.samples_reference.exr
    )
}
