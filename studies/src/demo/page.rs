//! The demonstration's report as one page.

use super::{
    Picture, Report,
    ladder::{CUT_SIZES, MAP_TOP, PATH_SAMPLES, Rung},
};
use crate::report::{
    self,
    chart::{AxisScale, Chart, Line, histogram},
    section,
    text::{grouped, megabytes, seconds},
};
use lapidary_render::compare::Metrics;
use maud::{Markup, html};

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

fn figure(class: &str, picture: &Picture, caption: Markup) -> Markup {
    report::figure(class, &picture.png, picture.size, &picture.title, caption)
}

fn hero(report: &Report) -> Markup {
    let picture = &report.gallery.hero;
    let caption = html! {
        "Lit by the whole environment “" (picture.look.illumination.environment.name) "” through lit cuts, in "
        (seconds(picture.seconds)) " on the CPU with " (picture.look.view.aa)
        " samples per pixel. No pixel is noisy: which lights each vertex sees was found once, in the bake."
    };
    html! {
        (figure("hero", picture, caption))
        div {
            h1 { "One bake, then any light and any material, free of noise" }
            p {
                "Each vertex keeps a " em { "visibility cut" } ": a coarse partition of the sky into clusters of directions, each \
                 seen or blocked to a known degree, fine only where shadows need it. Under an environment it becomes a "
                em { "lit cut" } ", fine only where light comes from. A pixel walks the lit cuts of three vertices in one pass, \
                 and evaluates the material at their nodes."
            }
        }
    }
}

fn key_figures(report: &Report) -> Markup {
    let shown = &report.ladder.lit;
    let bake = &report.bake;
    let environment = &report.gallery.environments[0];
    let samples = u64::from(environment.size[0]) * u64::from(environment.size[1]);
    let microseconds = 1e6 * environment.seconds / (samples * u64::from(environment.look.view.aa)) as f64;
    let lights = format!("in a cut, for {} light samples", grouped(bake.lights as u64));
    let vertices = format!("of cuts for {} vertices", grouped(bake.vertices as u64));
    html! {
        div.key {
            (key_figure(bake.seconds("total").unwrap_or(0.0), 0, "s", "to bake the scene, once"))
            (key_figure(bake.mean_cut, 0, "nodes", &lights))
            (key_figure(bake.bytes_cuts as f64 / 1e6, 1, "MB", &vertices))
            (key_figure(microseconds, 1, "µs", "for a pixel’s sample"))
            (key_figure(shown.metrics.flip, 3, "FLIP", "difference from ray tracing, 0 to 1"))
            (key_figure(report.seconds, 0, "s", "for all of this page"))
        }
    }
}

fn key_figure(value: f64, decimals: usize, unit: &str, text: &str) -> Markup {
    html! { div { b { (format!("{value:.decimals$}")) small { (unit) } } span { (text) } } }
}

fn ladder(report: &Report) -> Markup {
    let ladder = &report.ladder;
    let truth = html! {
        b { "Ray-traced reference" } (grouped(report.bake.lights as u64)) " light samples" br; "at every pixel" br;
        (seconds(ladder.samples_reference.seconds))
    };
    let chart = |title, metric: fn(&Metrics) -> f64| {
        let line = |name: &str, rungs: &[Rung]| Line {
            name: name.into(),
            points: rungs.iter().map(|r| (r.picture.look.illum_cut.into(), metric(&r.metrics))).collect(),
        };
        // Lit cuts have no size: a level line.
        let ends = [CUT_SIZES[0], CUT_SIZES[CUT_SIZES.len() - 1]];
        let lit =
            Line { name: "lit".into(), points: ends.map(|size| (size.into(), metric(&ladder.lit.metrics))).into() };
        let lines = [line("refined", &ladder.refined), line("once", &ladder.once), lit];
        Chart {
            title,
            x_label: "nodes of the illumination cut",
            x: AxisScale::Log,
            y: AxisScale::Linear,
            lines: &lines,
        }
        .svg()
    };
    let body = html! {
        p {
            "The illumination cut is the budget of a picture. It starts with the clusters whose radiance varies too much and \
             spends what is left on the brightest. The reference uses the same light samples but traces every shadow ray at \
             every pixel, so the difference is what the cuts cost. Lit cuts, as in the other pictures of this page, have no \
             illumination cut: they are coarse where little light comes from."
        }
        div.grid.six {
            @for rung in &ladder.refined { (figure("", &rung.picture, rung_caption(rung))) }
            (figure("", &ladder.lit.picture, rung_caption(&ladder.lit)))
            (figure("truth", &ladder.samples_reference, truth))
        }
        div.grid.two { (chart("Relative RMSE", |m| m.rel_rmse)) (chart("FLIP", |m| m.flip)) }
    };
    section("More nodes, less error", body)
}

fn rung_caption(rung: &Rung) -> Markup {
    let Metrics { rel_rmse, flip, ssim, .. } = rung.metrics;
    html! {
        b { (rung.picture.title) }
        "relative RMSE " (thousandths(rel_rmse)) br;
        "FLIP " (thousandths(flip)) ", SSIM " (thousandths(ssim)) br;
        (seconds(rung.picture.seconds))
    }
}

fn thousandths(value: f64) -> String {
    format!("{value:.3}")
}

fn refinement(report: &Report) -> Markup {
    let detail = &report.ladder.detail;
    let caption = |name: &str, picture: &Picture, metrics: &Metrics| {
        let evaluations = picture.stats.as_ref().map_or(0.0, |s| s.mean_brdf_evaluations);
        html! {
            b { (name) } (format!("{evaluations:.0}")) " BRDF evaluations per pixel, " (seconds(picture.seconds)) br;
            "relative RMSE " (thousandths(metrics.rel_rmse)) ", FLIP " (thousandths(metrics.flip))
        }
    };
    let truth = html! {
        b { "Path-traced reference" } (seconds(detail.path_reference.seconds)) " at " (PATH_SAMPLES) " samples per pixel; no cuts;"
        br; "its noise is part of the errors here"
    };
    let body = html! {
        p {
            "Sampling the material once for each node, as the paper did, makes blotches where a cluster is wider than the \
             highlight. The merge can halve such nodes as it meets them, with nothing precomputed and few more evaluations. Both \
             pictures have an illumination cut of " (detail.once.look.illum_cut) " nodes."
        }
        div.grid.three {
            (figure("", &detail.once, caption("Once per node", &detail.once, &detail.metrics_once)))
            (figure("", &detail.refined, caption("Refined", &detail.refined, &detail.metrics_refined)))
            (figure("truth", &detail.path_reference, truth))
        }
    };
    section("Glossy materials: refine where the lobe is narrow", body)
}

fn error_maps(report: &Report) -> Markup {
    let body = html! {
        p {
            "Relative error of each pixel against the ray-traced reference. With refinement it is left where shadows fall between \
             vertices, and does not depend on the light’s budget; without, it also sits in every highlight."
        }
        div.legend { "0" i {} (MAP_TOP) " and above" }
        h3 { "Refined" }
        (error_row(&report.ladder.refined))
        h3 { "Once per node" }
        (error_row(&report.ladder.once))
        h3 { "Lit cuts" }
        (error_row(std::slice::from_ref(&report.ladder.lit)))
    };
    section("Where the error is", body)
}

fn error_row(rungs: &[Rung]) -> Markup {
    html! {
        div.grid.five {
            @for rung in rungs {
                figure.map {
                    a href=(rung.error_map) { img src=(rung.error_map) alt="Error map"; }
                    figcaption { (rung.picture.title) ": " (thousandths(rung.metrics.rel_rmse)) }
                }
            }
        }
    }
}

fn gallery(report: &Report) -> Markup {
    let gallery = &report.gallery;
    let turned = capitalized(&gallery.rotations[0].look.illumination.environment.name.replace('-', " "));
    let environments = html! {
        p {
            "The bake knows nothing of light: a new environment only needs a new illumination cut, whose making is part of the \
             times below."
        }
        (gallery_row(&gallery.environments))
    };
    let rotations = html! {
        p { "“" (turned) "” turned about the vertical. Energy is conserved at every angle." }
        (gallery_row(&gallery.rotations))
    };
    let materials = html! {
        p { "Materials enter at the pixel, so they too are free to change. Here the whole scene takes one." }
        (gallery_row(&gallery.materials))
    };
    html! {
        (section("Any environment", environments))
        (section("Any rotation", rotations))
        (section("Any material", materials))
    }
}

fn gallery_row(pictures: &[Picture]) -> Markup {
    html! {
        div.grid.three {
            @for picture in pictures {
                (figure("", picture, html! { b { (capitalized(&picture.title)) } (seconds(picture.seconds)) }))
            }
        }
    }
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

fn bake(report: &Report) -> Markup {
    let b = &report.bake;
    let body = html! {
        p {
            "Cuts are split until each cluster’s error is below a bound (sigma " (format!("{:.1}", b.sigma)) "), so their size \
             follows the scene: open places need few nodes, the lantern’s filigree many. A cut of one node sees everything or \
             nothing."
        }
        @for warning in &b.warnings { p { "Warning: " (warning) } }
        div.grid.two {
            div { table { (bake_contents(report)) } }
            div { (histogram(&b.cut_size_histogram)) table { (bake_times(report)) } }
        }
    };
    section("The bake", body)
}

fn row(name: &str, value: &str, text: &str) -> Markup {
    html! { tr { td { (name) } td { (value) } td { (text) } } }
}

fn bake_contents(report: &Report) -> Markup {
    let (b, v) = (&report.bake, &report.verification);
    let added = format!("{} of them added where shadows need them", grouped((b.vertices - b.source_vertices) as u64));
    let at_most = format!("on average, {} at most; 16 bits each", b.max_cut);
    let whole = format!("of {} for the whole dataset", megabytes(b.bytes_total));
    let pairs = format!("{:.0} M", b.samples_resolved as f64 / 1e6);
    let again = format!("vertices, ray by ray; {} cuts differ", v.environment.different_cuts);
    html! {
        (row("Vertices", &grouped(b.vertices as u64), &added))
        (row("Triangles", &grouped(b.triangles as u64), "after tessellation"))
        (row("Light samples", &grouped(b.lights as u64), "directions, even over the sphere: leaves of the light tree"))
        (row("Nodes a cut", &format!("{:.1}", b.mean_cut), &at_most))
        (row("Visibility RMS", &thousandths(b.rms_visibility), "stored against traced, over vertices and lights"))
        (row("Cuts", &megabytes(b.bytes_cuts), &whole))
        (row("Pairs", &pairs, "of vertex and light"))
        (row("Buried points", &grouped(b.buried_points as u64), "lie inside other geometry and are not used"))
        (row("Traced again", &grouped(v.environment.vertices as u64), &again))
    }
}

fn bake_times(report: &Report) -> Markup {
    let b = &report.bake;
    let run = b.run.clone().unwrap_or_default();
    let phase = |name: &str| seconds(b.seconds(name).unwrap_or(0.0));
    let speed = format!("all pairs traced, {:.1} million a second, and cuts selected", run.samples_per_second / 1e6);
    let memory = format!("{} of memory at most", megabytes(run.peak_memory_bytes));
    html! {
        (row("Tessellation", &phase("tessellate"), "edges split where visibility bends between their ends"))
        (row("Pilot", &phase("pilot"), "visibility of a few vertices, to cluster the lights by"))
        (row("Light tree", &phase("tree"), "lights clustered by direction and pilot visibility"))
        (row("Visibility", &phase("visibility"), &speed))
        (row("Whole bake", &phase("total"), &memory))
    }
}

fn footer(report: &Report) -> Markup {
    let ladder = &report.ladder;
    let body = html! {
        p {
            "All figures are in " a href="report.json" { "report.json" } "; every picture lies beside this page as PNG and as \
             scene-linear EXR. The dataset is " code { "still-life.cuts" } ": relight it without baking again."
        }
        pre {
            code {
                "lapidary render still-life.cuts --env sun-sky:20 --rotate 40 --out evening.png\n\
                 lapidary render still-life.cuts --env studio --camera detail --roughness 0.2 --metalness 1 --out steel.png\n\
                 lapidary compare " (ladder.refined[0].picture.exr) " " (ladder.samples_reference.exr)
            }
        }
    };
    section("Go on from here", body)
}
