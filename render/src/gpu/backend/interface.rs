//! [`Backend`] by passes: what each call sets, begins, renders and reads back.

use super::{
    GpuBackend, bounce::ShownBounce, picture::Picture, pipelines::Pipelines, progress::SumState, shown::Loaded, texels,
};
use crate::{
    appearance::{Appearance, same_assignment},
    backend::{Backend, PictureStats, ShadedSamples},
    baked::Baked,
    device::{Compute, DeviceCuts, kernels::REPLACED_CUTS, pass::Pass, storage},
    error::BackendError,
    gpu::{frame::in_mirrors, light::scaled_map, materials::GpuMaterials, passes::check, posed, scene::GpuScene},
    light::{
        environment::{EnvironmentLight, Illumination},
        local::LocalLighting,
    },
    post::Post,
    sampling::BrdfSampling,
    shade::mirror::rays,
    sketch::Tiles,
    stale::{LightPart, Stale},
    summed::DirectStep,
    view::View,
};
use glam::Vec4;
use lapidary_core::image::{Image, Region};
use std::{ops::Range, sync::Arc};

impl Backend for GpuBackend {
    fn name(&self) -> String {
        self.pipelines.device.name().to_owned()
    }

    fn reload(&mut self) -> Result<(), BackendError> {
        self.set_path(self.path())
    }

    fn compute(&self) -> Compute {
        Compute::unless_emulated(&self.pipelines.device)
    }

    fn set_scene(&mut self, baked: &Baked) -> Result<(), BackendError> {
        let (gpu, dataset) = (self.pipelines.gpu(), &baked.dataset);
        let scene = GpuScene::new(gpu, dataset)?;
        let appearance = Appearance::of(&dataset.scene);
        let (materials, _) = GpuMaterials::new(gpu, &appearance, None);
        gpu.check()?;
        let patches: Vec<u32> = match dataset.has_bounces() {
            true => baked.patches().iter().map(|&patch| patch.into()).collect(),
            false => vec![0],
        };
        let patches = storage(gpu, "patches", bytemuck::cast_slice(&patches));
        let assigned = appearance.assigned.clone();
        if assigned.is_some() {
            scene.assign(gpu, dataset, &appearance);
        }
        self.compile_for(&appearance, true)?;
        let mirrors = rays::marks(&appearance, scene.leaf_solid_angle);
        let baked = baked.clone();
        self.shown.set_scene(Loaded {
            scene,
            patches,
            materials,
            assigned,
            mirrors,
            rays: None,
            has_tried_rays: false,
            baked,
        });
        self.progress.forget();
        Ok(())
    }

    fn pose(&mut self, posed: &Baked, cuts: Option<&DeviceCuts>) -> Result<(), BackendError> {
        let gpu = self.pipelines.gpu();
        let Some(mut loaded) = self.shown.scene.take() else { return Ok(()) };
        loaded.scene.pose(gpu, &loaded.baked.dataset, &posed.dataset)?;
        if let Some(cuts) = cuts {
            let kernel = self.pipelines.device.kernel(&REPLACED_CUTS)?;
            loaded.scene.take_cuts(gpu, &kernel, cuts)?;
        }
        if let Some((light, _)) = &mut self.shown.environment.light {
            light.replace_cuts(gpu, &self.pipelines.passes.lit, &loaded.scene)?;
        }
        (loaded.baked, loaded.rays, loaded.has_tried_rays) = (posed.clone(), None, false);
        self.shown.scene = Some(loaded);
        self.shown.forget_light();
        self.progress.forget();
        gpu.check()
    }

    fn set_appearance(&mut self, appearance: &Appearance) -> Result<Vec<String>, BackendError> {
        let gpu = self.pipelines.gpu();
        let Some(loaded) = self.shown.scene.take() else { return Ok(Vec::new()) };
        let (fitted, mut messages) = appearance.fitted(&loaded.baked.dataset.scene.materials);
        let (materials, scaled) = GpuMaterials::new(gpu, &fitted, Some(loaded.materials));
        messages.extend(scaled);
        if !same_assignment(&loaded.assigned, &fitted.assigned) {
            loaded.scene.assign(gpu, &loaded.baked.dataset, &fitted);
        }
        let mirrors = rays::marks(&fitted, loaded.scene.leaf_solid_angle);
        self.shown.scene = Some(Loaded { materials, assigned: fitted.assigned.clone(), mirrors, ..loaded });
        self.progress.picture = None;
        self.compile_for(&fitted, false)?;
        let Self { pipelines, shown, .. } = self;
        let uploaded = shown.scene.as_mut().map(|loaded| loaded.upload_rays(&pipelines.device, false));
        if let Some(Err(error)) = uploaded {
            messages.push(without_rays(&error));
        }
        pipelines.gpu().check()?;
        Ok(messages)
    }

    fn set_light(
        &mut self,
        light: &Illumination,
        lighting: &Arc<EnvironmentLight>,
    ) -> Result<Vec<String>, BackendError> {
        let Self { pipelines, shown, progress } = self;
        let (gpu, environment) = (pipelines.gpu(), &mut shown.environment);
        let known = environment.light.as_ref().is_some_and(|(_, e)| Arc::ptr_eq(e, &light.environment));
        progress.picture = None;
        let Some(Loaded { scene, .. }) = &shown.scene else { return Ok(Vec::new()) };
        environment.set(pipelines, scene, (light, lighting))?;
        gpu.check()?;
        let message = scaled_map(&light.environment, gpu.limits.max_texture_dimension_2d);
        Ok(message.filter(|_| !known).into_iter().collect())
    }

    fn set_local_lighting(&mut self, lighting: &LocalLighting) -> Result<Vec<String>, BackendError> {
        let Self { pipelines, shown, progress } = self;
        shown.local = lighting.clone();
        progress.picture = None;
        shown.bounce.set(ShownBounce::of(lighting));
        let radius = shown.scene.as_ref().map_or(1.0, |loaded| 0.5 * loaded.scene.bounds.diagonal());
        let mut remarks: Vec<String> = shown.local_lights.set(&lighting.shown_lights(), radius).into_iter().collect();
        if let Some(loaded) = shown.scene.as_mut().filter(|_| shown.local_lights.have_suns())
            && let Err(error) = loaded.upload_rays(&pipelines.device, true)
        {
            remarks.push(without_rays(&error));
        }
        if let Some(loaded) = &mut shown.scene {
            let posed = shown.bounce.light.posed.as_deref();
            loaded.scene.posed = posed::texture(pipelines.gpu(), posed, lighting.components.environment);
        }
        pipelines.gpu().check()?;
        Ok(remarks)
    }

    fn begin(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        self.progress.history = None;
        self.begin_anew(view, sampling)
    }

    fn resume(&mut self, view: &View, sampling: BrdfSampling, stale: &Stale) -> Result<(), BackendError> {
        self.pipelines.check_size(view.size)?;
        let lights = self.shown.local.shown_lights();
        let shows_same = |state: &SumState| state.summed.has_light_of(view, sampling, stale, &lights);
        if self.progress.picture.is_some() && self.progress.state.as_ref().is_some_and(shows_same) {
            self.remember()?;
        } else {
            self.progress.history = None;
        }
        let kept = self.progress.state.take().filter(|state| state.summed.stays(view, sampling, stale));
        let Some(mut state) = kept else { return self.begin_anew(view, sampling) };
        self.progress.picture = None;
        let before = (&state.plan, state.summed.is_complete());
        let step = self.shown.step_lights(&mut state.summed.lights, Some(before));
        self.progress.picture = Some(self.prepared(view, sampling)?);
        (state.plan, state.summed.complete) = (self.shown.local_lights.plan().clone(), 0);
        self.progress.state = Some(state);
        let Self { pipelines, progress, .. } = self;
        let mirrors = self.shown.loaded().mirrors;
        let (pixels, merges_added) = (|part| step.forgets(stale, part, mirrors), step == DirectStep::MergeAndAdd);
        pipelines.submit(|encoder| progress.encode_kept(pipelines, encoder, pixels, merges_added))
    }

    fn is_ready(&mut self) -> Result<bool, BackendError> {
        let Self { pipelines, progress, .. } = self;
        let Some(picture) = &progress.picture else { return Ok(true) };
        pipelines.compile_soon();
        let needed = || picture.needed.iter().chain(pipelines.passes.of_sketches());
        if needed().all(Pass::is_compiled) { check(needed()).map(|()| true) } else { Ok(false) }
    }

    fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError> {
        if rows.is_empty() {
            return Ok(());
        }
        if rows.start == 0 {
            check(self.progress.picture().needed.iter())?;
            self.write_frame(sample, 1);
            self.progress.leave_sketch(sample);
        }
        let Self { pipelines, progress, .. } = self;
        let [width, height] = progress.picture().view.size;
        let area = Region { x: 0, y: rows.start, width, height: rows.end - rows.start };
        pipelines.submit(|encoder| {
            if rows.start == 0 {
                progress.encode_seen(&pipelines.passes, encoder, sample);
            }
            progress.encode_parts(&pipelines.passes, encoder, 1, &[area]);
        })?;
        if rows.end == height {
            progress.sample_done(sample);
        }
        Ok(())
    }

    fn sketch(&mut self, stride: u32, tiles: &[u32]) -> Result<(), BackendError> {
        self.write_frame(0, stride);
        let Self { pipelines, progress, .. } = self;
        let Picture { view, lattices, .. } = progress.picture();
        let (all, is_first) = (Tiles::of(view.size), lattices.making.is_none());
        if is_first {
            check(progress.picture().needed.iter())?;
        }
        let areas: Vec<Region> = tiles.iter().map(|&tile| all.on_lattice(tile, stride)).collect();
        pipelines.submit(|encoder| {
            if is_first {
                progress.encode_seen(&pipelines.passes, encoder, 0);
            }
            progress.encode_parts(&pipelines.passes, encoder, stride, &areas);
        })?;
        let Some(picture) = &mut progress.picture else { return Ok(()) };
        picture.lattices.add(stride, tiles, all.count());
        if picture.lattices.complete == Some(1) {
            // Nothing is filled any more.
            progress.history = None;
            progress.sample_done(0);
        }
        Ok(())
    }

    /// Fills from the finest lattice that all tiles have, and shades no pixel itself: the next lattice comes sooner.
    fn fill(&mut self, _most_shaded: u32) -> Result<u32, BackendError> {
        let Picture { view, lattices, .. } = self.progress.picture();
        let Some(stride) = lattices.complete.filter(|&stride| stride > 1) else { return Ok(0) };
        let all = Tiles::of(view.size);
        let areas: Vec<Region> =
            (0..all.count()).filter(|&tile| !lattices.has_sample(tile)).map(|tile| all.region(tile)).collect();
        self.write_frame(0, stride);
        let Self { pipelines, progress, .. } = self;
        let is_unpredicted = progress.take_unpredicted();
        pipelines.submit(|encoder| {
            if is_unpredicted {
                progress.encode_predicted(pipelines, encoder);
            }
            progress.encode_sketch(&pipelines.passes, encoder, stride, &areas);
        })?;
        if let Some(picture) = &mut progress.picture {
            (picture.lattices.filled, picture.lattices.was_filled) = (true, true);
        }
        Ok(0)
    }

    fn display(&mut self, post: &Post, _samples: u32) -> Result<Vec<[u8; 4]>, BackendError> {
        let Self { pipelines, progress, .. } = self;
        let uniforms = progress.picture().display(post);
        pipelines.gpu().queue.write_buffer(&pipelines.uniforms.display, 0, bytemuck::bytes_of(&uniforms));
        pipelines.submit(|encoder| progress.encode_display(&pipelines.passes, encoder))?;
        texels(pipelines.gpu(), &progress.targets().shown)
    }

    fn read(&mut self, _samples: u32) -> Result<(Image, Vec<f32>), BackendError> {
        let Self { pipelines, progress, .. } = self;
        let (gpu, size) = (pipelines.gpu(), progress.targets().size);
        let mut sum = vec![Vec4::ZERO; size[0] as usize * size[1] as usize];
        let mut coverage = Vec::new();
        for (part, sums) in progress.sums() {
            let work: Vec<[u32; 4]> = texels(gpu, &sums.work)?;
            let samples = |work: &[u32; 4]| (work[2] & 0xffff).max(1) as f32;
            for ((pixel, value), work) in sum.iter_mut().zip(texels::<[f32; 4]>(gpu, &sums.value)?).zip(&work) {
                *pixel += Vec4::from(value) / samples(work);
            }
            if part == LightPart::Environment {
                coverage = work.iter().map(|work| (work[3] & 0xffff) as f32 / samples(work)).collect();
            }
        }
        let lets_through = progress.picture.as_ref().is_some_and(Picture::lets_light_through);
        let through = |pixel: &Vec4| if lets_through { pixel.w } else { 0.0 };
        coverage.iter_mut().zip(&sum).for_each(|(covered, pixel)| *covered = (*covered - through(pixel)).max(0.0));
        let pixels = sum.iter().map(|pixel| pixel.truncate() - through(pixel)).collect();
        Ok((Image { size, pixels }, coverage))
    }

    fn stats(&mut self) -> Result<PictureStats, BackendError> {
        let (mut points, mut nodes, mut evaluations, mut shaded) = (0, 0, 0, [0; LightPart::COUNT]);
        for (part, sums) in self.progress.sums() {
            let work: Vec<[u32; 4]> = texels(self.pipelines.gpu(), &sums.work)?;
            let sum = |of: fn(&[u32; 4]) -> u32| work.iter().map(|work| u64::from(of(work))).sum::<u64>();
            // What mirrors show has widths of lobes there.
            if part != LightPart::Mirrors {
                nodes += sum(|work| work[0]);
                evaluations += sum(|work| work[1]);
            }
            shaded[part as usize] = sum(|work| work[3] >> 16);
            if part == LightPart::Environment {
                points = sum(|work| work[2] >> 16);
            }
        }
        let mean = |sum: u64| sum as f64 / points.max(1) as f64;
        Ok(PictureStats {
            pixels_shaded: points,
            mean_merged_nodes: mean(nodes),
            mean_brdf_evaluations: mean(evaluations),
            shaded: ShadedSamples::of(shaded),
        })
    }
}

/// Tells once for both that rays meet nothing.
fn without_rays(error: &BackendError) -> String {
    format!("mirrors show the environment alone, and suns shine without shadows: {error}")
}

impl GpuBackend {
    /// Uniforms of a sample, for every `stride`th pixel of every `stride`th row.
    pub(super) fn write_frame(&self, sample: u32, stride: u32) {
        let picture = self.progress.picture();
        let frame = self.shown.frame(picture, sample, stride);
        let Pipelines { device, uniforms, .. } = &self.pipelines;
        let write = |buffer, frame| device.gpu.queue.write_buffer(buffer, 0, bytemuck::bytes_of(&frame));
        write(&uniforms.frame, frame);
        for (mirrors, of_parts) in (1..).zip(&uniforms.mirrored).filter(|_| picture.has_mirrors()) {
            for (others, buffer) in (0..).zip(of_parts) {
                write(buffer, in_mirrors(frame, mirrors, others));
            }
        }
    }
}
