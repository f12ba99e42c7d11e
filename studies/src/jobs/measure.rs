//! The thread that measures the difference of the picture with cuts from the reference and prepares its display: the displayed
//! reference, metrics, the error map and its histogram. The latest request wins.

use super::{
    Wake,
    comparison::{ReferencePicture, TestPicture},
    guarded, spawn,
};
use crate::sheet::DisplayPicture;
use anyhow::{Result, bail};
use glam::Vec3;
use lapidary_core::image::{Image, Region};
use lapidary_render::{
    Post,
    compare::{
        Metrics, compare,
        map::{ErrorField, ErrorMap},
    },
};
use std::sync::{
    Arc,
    mpsc::{Receiver, Sender, channel},
};

/// Two pictures to measure, and options.
#[derive(Clone, Debug)]
pub struct MeasureRequest {
    /// The picture with cuts.
    pub test: Arc<TestPicture>,
    /// The reference.
    pub reference: ReferencePicture,
    /// Treats pixels without surfaces as equal, so that no background hides an error.
    pub surfaces_only: bool,
    /// The only region to measure, in comparison pixels.
    pub region: Option<Region>,
    /// Error to map.
    pub map: ShownMap,
    /// The error at the end of the map's colors; `None` to find it.
    pub top: Option<f32>,
    /// Display settings of the reference.
    pub post: Post,
}

/// Quantity of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShownMap {
    /// The picture's difference from the reference.
    Error(ErrorMap),
    /// Its predicted error, from the variances within its clusters.
    Predicted,
}

impl ShownMap {
    /// All maps in menu order.
    pub const ALL: [Self; 5] = [
        Self::Error(ErrorMap::Relative),
        Self::Error(ErrorMap::Absolute),
        Self::Error(ErrorMap::Signed),
        Self::Error(ErrorMap::Flip),
        Self::Predicted,
    ];

    /// Display name.
    pub fn title(self) -> &'static str {
        match self {
            Self::Error(map) => map.title(),
            Self::Predicted => "Predicted error",
        }
    }
}

/// Measured differences.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Metrics of the traced pixels, inside the region if given.
    pub metrics: Metrics,
    /// Error of each of these pixels.
    pub field: ErrorField,
    /// The errors as colors.
    pub map: DisplayPicture,
    /// Part of the picture in the map, as shares of its width and height: left, top, right, bottom.
    pub part: [f32; 4],
    /// Relative RMSE of the reference by its own noise, over the same pixels.
    pub noise: Option<f64>,
    /// The measured reference.
    pub reference: ReferencePicture,
    /// The measured picture.
    pub test: Arc<TestPicture>,
}

/// A result of the thread.
#[derive(Debug)]
pub enum MeasureEvent {
    /// The reference as displayed.
    Shown(DisplayPicture),
    /// The measurement.
    Measured(Box<Measured>),
    /// Reason why the pictures cannot be compared.
    Failed(String),
}

/// The window's handle of the thread.
pub struct MeasureThread {
    requests: Sender<(u64, MeasureRequest)>,
    events: Receiver<(u64, MeasureEvent)>,
}

impl MeasureThread {
    /// Starts the thread.
    pub fn start(wake: Wake) -> Self {
        let (requests, inbox) = channel::<(u64, MeasureRequest)>();
        let (outbox, events) = channel();
        spawn("measure", move || {
            while let Ok(first) = inbox.recv() {
                let (number, request) = inbox.try_iter().last().unwrap_or(first);
                let tell = |event| {
                    // The receiver is gone if the window is closed.
                    let _ = outbox.send((number, event));
                    wake();
                };
                let traced = request.reference.image.every(request.reference.step);
                tell(MeasureEvent::Shown(DisplayPicture::shown(&traced, &request.post)));
                tell(match guarded("the comparison", || measure(&request)) {
                    Ok(measured) => MeasureEvent::Measured(Box::new(measured)),
                    Err(text) => MeasureEvent::Failed(text),
                });
            }
        });
        Self { requests, events }
    }

    /// Requests the measurement of two pictures; the result carries `number`.
    pub fn request(&self, number: u64, request: MeasureRequest) {
        // The thread only ends with the window.
        let _ = self.requests.send((number, request));
    }

    /// Results since the last call.
    pub fn events(&self) -> Vec<(u64, MeasureEvent)> {
        self.events.try_iter().collect()
    }
}

fn measure(request: &MeasureRequest) -> Result<Measured> {
    let MeasureRequest { test, reference, region, .. } = request;
    let step = reference.step;
    let region = match region {
        None => None,
        Some(region) => match region.within(reference.image.size).and_then(|inside| inside.every(step)) {
            None => bail!("the region has no pixel that is traced; draw a larger one"),
            found => found,
        },
    };
    let covered =
        |image: &Image| if request.surfaces_only { on_surfaces(image, &test.coverage) } else { image.clone() };
    let part = |image: &Image| {
        let traced = covered(image).every(step);
        region.map_or(traced.clone(), |region| traced.crop(region))
    };
    let (a, b) = (part(&test.image), part(&reference.image));
    let metrics = compare(&a, &b)?;
    let field = match (request.map, &test.predicted) {
        (ShownMap::Error(map), _) => ErrorField::new(&a, &b, map, request.top)?,
        (ShownMap::Predicted, Some(predicted)) => ErrorField::predicted(&part(predicted), request.top)?,
        (ShownMap::Predicted, None) => {
            bail!("only errors of the environment's light can be predicted; choose another map")
        }
    };
    let map = DisplayPicture::of_display(field.size, field.colors().into_iter());
    let whole = reference.image.size.map(|side| side.div_ceil(step));
    let part = region.map_or([0.0, 0.0, 1.0, 1.0], |region| shares(region, whole));
    let noise = reference.noise.map(|noise| noise * root_of_squares(&reference.image) / root_of_squares(&b).max(1e-30));
    Ok(Measured { metrics, field, map, part, noise, reference: reference.clone(), test: test.clone() })
}

/// Over the finite pixels. The background has no noise, so the noise of the whole picture belongs to its surfaces.
fn root_of_squares(image: &Image) -> f64 {
    let finite = image.pixels.iter().filter(|pixel| pixel.is_finite());
    finite.map(|pixel| pixel.as_dvec3().length_squared()).sum::<f64>().sqrt()
}

fn shares(region: Region, [width, height]: [u32; 2]) -> [f32; 4] {
    let (columns, rows) = (region.columns(), region.rows());
    let [across, down] = [width as f32, height as f32];
    [columns.start as f32 / across, rows.start as f32 / down, columns.end as f32 / across, rows.end as f32 / down]
}

/// The picture, black where there is no surface.
fn on_surfaces(image: &Image, coverage: &[f32]) -> Image {
    let pixel = |(&p, &covered): (&Vec3, &f32)| if covered > 0.0 { p } else { Vec3::ZERO };
    Image { size: image.size, pixels: image.pixels.iter().zip(coverage).map(pixel).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::testing::{silent, wait_for};
    use lapidary_render::PictureStats;

    fn request(test: Image, reference: Image) -> MeasureRequest {
        let coverage = (0..test.pixels.len()).map(|i| if i < 4 { 0.0 } else { 1.0 }).collect();
        MeasureRequest {
            test: Arc::new(TestPicture {
                image: test,
                coverage,
                predicted: None,
                stats: PictureStats::default(),
                millis: 1.0,
            }),
            reference: ReferencePicture { image: reference.into(), step: 1, noise: None, finished: true, seconds: 1.0 },
            surfaces_only: false,
            region: None,
            map: ShownMap::Error(ErrorMap::Absolute),
            top: None,
            post: Post::default(),
        }
    }

    /// The first four pixels are background and bright.
    fn picture(surface: f32) -> Image {
        Image::from_fn([8, 6], |x, y| Vec3::splat(if y == 0 && x < 4 { 100.0 } else { surface }))
    }

    #[test]
    fn a_bright_background_hides_the_error_unless_surfaces_alone_count() {
        let request = request(picture(1.1), picture(1.0));
        let noisy = ReferencePicture { noise: Some(1e-3), ..request.reference.clone() };
        let noise = |surfaces_only| {
            measure(&MeasureRequest { reference: noisy.clone(), surfaces_only, ..request.clone() })
                .unwrap()
                .noise
                .unwrap()
        };
        // The picture's root of squares is 346.6 with the background and 11.49 without.
        assert!((noise(false) - 1e-3).abs() < 1e-9 && (noise(true) - 0.030_167).abs() < 1e-5, "{}", noise(true));
        let with_background = measure(&request).unwrap().metrics;
        let on_surfaces = measure(&MeasureRequest { surfaces_only: true, ..request }).unwrap().metrics;
        assert!((on_surfaces.rel_rmse - 0.1).abs() < 1e-5, "{on_surfaces:?}");
        assert!(with_background.rel_rmse < 0.01, "negative control: {with_background:?}");
    }

    #[test]
    fn a_region_is_measured_alone_and_only_where_it_was_traced() {
        let mut test = picture(1.0);
        test.pixels[8 * 4 + 6] = Vec3::splat(2.0);
        let request = request(test, picture(1.0));
        let of = |[x, y]: [u32; 2], [width, height]: [u32; 2], step| {
            let reference = ReferencePicture { step, ..request.reference.clone() };
            measure(&MeasureRequest { region: Some(Region { x, y, width, height }), reference, ..request.clone() })
        };
        let around = of([6, 4], [2, 2], 1).unwrap();
        assert!((around.metrics.rmse - 0.5).abs() < 1e-6 && around.metrics.pixels == 4, "{:?}", around.metrics);
        assert_eq!(around.part, [0.75, 4.0 / 6.0, 1.0, 1.0]);
        assert_eq!(of([4, 1], [2, 2], 1).unwrap().metrics.rmse, 0.0, "negative control: beside it");
        assert_eq!(of([6, 4], [2, 2], 2).unwrap().metrics.pixels, 1, "every other pixel was traced");
        assert!(of([5, 5], [1, 1], 4).unwrap_err().to_string().contains("draw a larger one"));
        assert!(of([80, 5], [9, 9], 1).is_err());
    }

    #[test]
    fn a_predicted_error_is_mapped_as_it_is_or_it_is_told_why_there_is_none() {
        let mut request = request(picture(1.1), picture(1.0));
        request.map = ShownMap::Predicted;
        assert!(measure(&request).unwrap_err().to_string().contains("choose another map"));
        let predicted = Some(Image::filled([8, 6], Vec3::splat(0.25)));
        request.test = TestPicture { predicted, ..TestPicture::clone(&request.test) }.into();
        let measured = measure(&request).unwrap();
        assert!(measured.field.errors.iter().all(|&e| (e - 0.25).abs() < 1e-6), "not the 0.1 that they differ by");
        assert_eq!(measured.field.title, "Predicted error");
    }

    #[test]
    fn pixels_that_are_not_finite_are_counted_and_shown_in_magenta() {
        let mut reference = picture(1.0);
        reference.pixels[20] = Vec3::new(f32::NAN, 0.0, 0.0);
        let measured = measure(&request(picture(1.0), reference)).unwrap();
        assert_eq!((measured.metrics.non_finite_pixels, measured.metrics.rmse), (1, 0.0));
        assert_eq!(measured.map.pixels[20], [255, 0, 255, 255]);
        assert_eq!(measured.map.pixels[21], [0, 0, 4, 255], "no error beside it");
    }

    #[test]
    fn the_thread_shows_the_reference_exposed_and_says_what_it_cannot_compare() {
        let thread = MeasureThread::start(silent());
        let bright = Post { exposure: 1.0, ..Post::default() };
        thread.request(7, MeasureRequest { post: bright, ..request(picture(0.25), picture(0.25)) });
        let mut events = Vec::new();
        wait_for("both events", || {
            events.extend(thread.events());
            (events.len() == 2).then_some(())
        });
        let [(7, MeasureEvent::Shown(shown)), (7, MeasureEvent::Measured(measured))] = &events[..] else {
            panic!("{events:?}")
        };
        assert_eq!(shown.pixels[9], [188, 188, 188, 255], "a half, encoded");
        assert_eq!(measured.metrics.rmse, 0.0);
        thread.request(8, request(picture(1.0), Image::filled([3, 3], Vec3::ONE)));
        let failed = wait_for("the failure", || {
            thread.events().into_iter().find_map(|(_, e)| match e {
                MeasureEvent::Failed(text) => Some(text),
                _ => None,
            })
        });
        assert!(failed.contains("8 x 6") && failed.contains("3 x 3"), "{failed}");
    }
}
