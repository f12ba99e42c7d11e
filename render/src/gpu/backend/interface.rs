//! [`Backend`] by passes: what each call sets, begins, renders and reads back.

use super::{GpuBackend, Loaded, SumState, bounce::ShownBounce, picture::Picture};
use crate::{
    appearance::{Appearance, same_assignment},
    backend::{Backend, PictureStats, ShadedSamples},
    baked::Baked,
    device::{Compute, readback, storage},
    error::BackendError,
    gpu::{
        light::{GpuLight, scaled_map},
        materials::GpuMaterials,
        meshless::GpuMeshless,
        passes::Passes,
        posed,
        scene::GpuScene,
    },
    light::{
        environment::{Illumination, SceneLighting},
        local::LocalLighting,
    },
    post::Post,
    sampling::BrdfSampling,
    sketch::Tiles,
    stale::{Part, Stale},
    summed::DirectStep,
    view::View,
};
use glam::Vec4;
use lapidary_core::image::{Image, Region};
use std::{ops::Range, sync::Arc};

impl Backend for GpuBackend {
    fn name(&self) -> String {
        self.gpu.info.name.clone()
    }

    fn reload(&mut self) -> Result<(), BackendError> {
        self.passes = Passes::new(&self.gpu, &self.shaders, &self.passes.variants())?;
        self.local_lights.forget_shadows();
        (self.picture, self.state, self.history) = (None, None, None);
        Ok(())
    }

    fn compute(&self) -> Compute {
        Compute::unless_emulated(&self.device)
    }

    fn set_scene(&mut self, baked: &Baked) -> Result<(), BackendError> {
        let dataset = &baked.dataset;
        let scene = GpuScene::new(&self.gpu, dataset)?;
        let appearance = Appearance::of(&dataset.scene);
        let (materials, _) = GpuMaterials::new(&self.gpu, &appearance, None);
        self.gpu.check()?;
        let patches: Vec<u32> = match dataset.has_bounces() {
            true => baked.patches().iter().map(|&patch| patch.into()).collect(),
            false => vec![0],
        };
        let patches = storage(&self.gpu, "patches", bytemuck::cast_slice(&patches));
        self.compile_for(&appearance, true)?;
        let assigned = appearance.assigned.clone();
        if assigned.is_some() {
            scene.assign(&self.gpu, dataset, &appearance);
        }
        self.scene = Some(Loaded { scene, patches, materials, assigned, dataset: dataset.clone() });
        self.forget_light();
        (self.light, self.dark, self.sources) = (None, None, None);
        self.meshless = GpuMeshless::default();
        Ok(())
    }

    fn pose(&mut self, posed: &Baked) -> Result<(), BackendError> {
        let Some(mut loaded) = self.scene.take() else { return Ok(()) };
        loaded.scene.pose(&self.gpu, &posed.dataset)?;
        loaded.dataset = posed.dataset.clone();
        self.scene = Some(loaded);
        self.forget_light();
        self.gpu.check()
    }

    fn set_appearance(&mut self, appearance: &Appearance) -> Result<Vec<String>, BackendError> {
        let Some(loaded) = self.scene.take() else { return Ok(Vec::new()) };
        let (fitted, mut messages) = appearance.fitted(&loaded.dataset.scene.materials);
        let (materials, scaled) = GpuMaterials::new(&self.gpu, &fitted, Some(loaded.materials));
        messages.extend(scaled);
        if !same_assignment(&loaded.assigned, &fitted.assigned) {
            loaded.scene.assign(&self.gpu, &loaded.dataset, &fitted);
        }
        self.scene = Some(Loaded { materials, assigned: fitted.assigned.clone(), ..loaded });
        self.picture = None;
        self.compile_for(&fitted, false)?;
        self.gpu.check()?;
        Ok(messages)
    }

    fn set_light(&mut self, light: &Illumination, lighting: &Arc<SceneLighting>) -> Result<Vec<String>, BackendError> {
        let known = self.light.as_ref().is_some_and(|(_, e)| Arc::ptr_eq(e, &light.environment));
        self.picture = None;
        let Some(Loaded { scene, .. }) = &self.scene else { return Ok(Vec::new()) };
        let lit =
            GpuLight::new(&self.gpu, &self.passes.lit, scene, light, lighting, self.light.as_ref().map(|(l, _)| l))?;
        self.light = Some((lit, light.environment.clone()));
        self.gpu.check()?;
        let message = scaled_map(&light.environment, self.gpu.limits.max_texture_dimension_2d);
        Ok(message.filter(|_| !known).into_iter().collect())
    }

    fn set_local_lighting(&mut self, lighting: &LocalLighting) -> Result<Vec<String>, BackendError> {
        self.local = lighting.clone();
        self.picture = None;
        let radius = self.scene.as_ref().map_or(1.0, |loaded| 0.5 * loaded.scene.bounds.diagonal());
        self.bounce = ShownBounce::of(lighting);
        if self.bounce.functions.is_none() {
            self.meshless.forget_light();
        }
        let remark = self.local_lights.set(&lighting.shown_lights(), radius);
        if let Some(loaded) = &mut self.scene {
            loaded.scene.posed =
                posed::texture(&self.gpu, self.bounce.posed.as_deref(), lighting.components.environment);
        }
        self.gpu.check()?;
        Ok(remark.into_iter().collect())
    }

    fn begin(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        self.history = None;
        self.begin_anew(view, sampling)
    }

    fn resume(&mut self, view: &View, sampling: BrdfSampling, stale: &Stale) -> Result<(), BackendError> {
        self.check_size(view.size)?;
        let lights = self.local.shown_lights();
        let shows_same = |state: &SumState| state.summed.has_light_of(view, sampling, stale, &lights);
        if self.picture.is_some() && self.state.as_ref().is_some_and(shows_same) {
            self.remember()?;
        } else {
            self.history = None;
        }
        let kept = self.state.take().filter(|state| state.summed.stays(view, sampling, stale));
        let Some(mut state) = kept else { return self.begin_anew(view, sampling) };
        self.picture = None;
        let before = (&state.plan, state.summed.is_complete());
        let step = self.step_lights(&mut state.summed.lights, Some(before));
        self.picture = Some(self.prepared(view, sampling)?);
        (state.plan, state.summed.complete) = (self.local_lights.plan().clone(), 0);
        self.state = Some(state);
        self.submit(|s, encoder| {
            s.encode_kept(encoder, |part| step.forgets(stale, part), step == DirectStep::MergeAndAdd)
        })
    }

    fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError> {
        if rows.is_empty() {
            return Ok(());
        }
        if rows.start == 0 {
            self.write_frame(sample, 1);
            self.leave_sketch(sample);
        }
        let width = self.picture().view.size[0];
        let area = Region { x: 0, y: rows.start, width, height: rows.end - rows.start };
        self.submit(|s, encoder| {
            if rows.start == 0 {
                s.encode_visibility(encoder);
                s.encode_marks(encoder, sample);
                s.encode_deferred(encoder);
            }
            s.encode_parts(encoder, 1, &[area]);
        })?;
        if rows.end == self.picture().view.size[1] {
            self.sample_done(sample);
        }
        Ok(())
    }

    fn sketch(&mut self, stride: u32, tiles: &[u32]) -> Result<(), BackendError> {
        let Picture { view, lattices, .. } = self.picture();
        let (all, is_first) = (Tiles::of(view.size), lattices.making.is_none());
        let areas: Vec<Region> = tiles.iter().map(|&tile| all.on_lattice(tile, stride)).collect();
        self.write_frame(0, stride);
        self.submit(|s, encoder| {
            if is_first {
                s.encode_visibility(encoder);
                s.encode_marks(encoder, 0);
                s.encode_deferred(encoder);
            }
            s.encode_parts(encoder, stride, &areas);
        })?;
        let Some(picture) = &mut self.picture else { return Ok(()) };
        picture.lattices.add(stride, tiles, all.count());
        if picture.lattices.complete == Some(1) {
            // Nothing is filled any more.
            self.history = None;
            self.sample_done(0);
        }
        Ok(())
    }

    /// Fills from the finest lattice that all tiles have, and shades no pixel itself: the next lattice comes sooner.
    fn fill(&mut self, _most_shaded: u32) -> Result<u32, BackendError> {
        let Picture { view, lattices, .. } = self.picture();
        let Some(stride) = lattices.complete.filter(|&stride| stride > 1) else { return Ok(0) };
        let all = Tiles::of(view.size);
        let areas: Vec<Region> =
            (0..all.count()).filter(|&tile| !lattices.has_sample(tile)).map(|tile| all.region(tile)).collect();
        self.write_frame(0, stride);
        let is_unpredicted = self.take_unpredicted();
        self.submit(|s, encoder| {
            if is_unpredicted {
                s.encode_predicted(encoder);
            }
            s.encode_sketch(encoder, stride, &areas);
        })?;
        if let Some(picture) = &mut self.picture {
            (picture.lattices.filled, picture.lattices.was_filled) = (true, true);
        }
        Ok(0)
    }

    fn display(&mut self, post: &Post, _samples: u32) -> Result<Vec<[u8; 4]>, BackendError> {
        self.write_display(post);
        self.submit(|s, encoder| s.encode_display(encoder))?;
        Ok(bytemuck::pod_collect_to_vec(&readback::read(&self.gpu, &self.targets().shown.texture)?))
    }

    fn read(&mut self, _samples: u32) -> Result<(Image, Vec<f32>), BackendError> {
        let size = self.targets().size;
        let mut sum = vec![Vec4::ZERO; size[0] as usize * size[1] as usize];
        let mut coverage = Vec::new();
        for (part, sums) in self.sums() {
            let work = self.read_texels::<u32>(&sums.work)?;
            let samples = |work: &[u32; 4]| (work[2] & 0xffff).max(1) as f32;
            for ((pixel, value), work) in sum.iter_mut().zip(self.read_texels::<f32>(&sums.value)?).zip(&work) {
                *pixel += Vec4::from(value) / samples(work);
            }
            if part == Part::Environment {
                coverage = work.iter().map(|work| (work[3] & 0xffff) as f32 / samples(work)).collect();
            }
        }
        let lets_through = self.picture.as_ref().is_some_and(Picture::lets_light_through);
        let through = |pixel: &Vec4| if lets_through { pixel.w } else { 0.0 };
        coverage.iter_mut().zip(&sum).for_each(|(covered, pixel)| *covered = (*covered - through(pixel)).max(0.0));
        let pixels = sum.iter().map(|pixel| pixel.truncate() - through(pixel)).collect();
        Ok((Image { size, pixels }, coverage))
    }

    fn stats(&mut self) -> Result<PictureStats, BackendError> {
        let (mut points, mut nodes, mut evaluations, mut shaded) = (0, 0, 0, [0; Part::COUNT]);
        for (part, sums) in self.sums() {
            let work = self.read_texels::<u32>(&sums.work)?;
            let sum = |of: fn(&[u32; 4]) -> u32| work.iter().map(|work| u64::from(of(work))).sum::<u64>();
            nodes += sum(|work| work[0]);
            evaluations += sum(|work| work[1]);
            shaded[part as usize] = sum(|work| work[3] >> 16);
            if part == Part::Environment {
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
