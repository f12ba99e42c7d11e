//! [`LeafSight`] on an adapter. If the adapter fails, the cores take over.

use super::{
    cuts::NewCuts,
    gloss::Gloss,
    seen::{CoreSight, LeafSight, Reflection, VertexLighting},
};
use crate::{
    device::{
        CutRequest, CutTables, DeviceCuts, GlossRequest, GlossTable, GpuForest, GpuImplicit, SeenLight, SharedDevice,
        VertexPlanes, VertexRequest,
    },
    error::BackendError,
};
use glam::Vec3;
use lapidary_core::{
    implicit::{BinLayout, Lighting, Views, disc_forest::DiscForest, forest::SurfelForest},
    scene::Mesh,
    surfel::Surfel,
};
use std::{borrow::Cow, collections::BTreeSet, ops::Range};

/// Leaf visibility, computed by an adapter.
pub struct GpuSight {
    /// `None` after a failure.
    gpu: Option<GpuForest>,
    cores: CoreSight,
    /// What stays of cuts; `None` before the first.
    tables: Option<CutTables>,
    device: SharedDevice,
    /// Glossy leaves, and their materials if the adapter takes them.
    gloss: Option<(Gloss, Option<GlossTable>)>,
    layout: BinLayout,
}

impl GpuSight {
    /// `None` if the adapter cannot hold the forest.
    pub fn new(device: &SharedDevice, forest: &SurfelForest, vertices: usize, layout: BinLayout) -> Option<Self> {
        if forest.discs().discs().is_empty() {
            return None;
        }
        let gpu = GpuImplicit::on(device).and_then(|implicit| implicit.forest(forest, vertices, layout)).ok()?;
        Some(Self {
            gpu: Some(gpu),
            cores: CoreSight::new(layout),
            tables: None,
            device: device.clone(),
            gloss: None,
            layout,
        })
    }

    /// The materials of glossy leaves on the adapter, `None` in place of those that it does not take; `None` while it compiles.
    fn table_of(&self, gloss: &Gloss, mesh: &Mesh, surfels: &[Surfel]) -> Option<Option<GlossTable>> {
        let (Some(gpu), Some(models)) = (&self.gpu, gloss.models()) else { return Some(None) };
        let kernel = self.device.gloss_kernel(&models)?;
        let (leaves, values) = gloss.packed(mesh, surfels);
        Some(gpu.gloss_table(kernel, leaves, &values))
    }

    /// Result from the adapter; `None` from its first failure on. The cores then recompute the adapter's last result.
    fn on_gpu<T>(
        &mut self,
        forest: &DiscForest,
        work: impl FnOnce(&mut GpuForest) -> Result<T, BackendError>,
    ) -> Option<T> {
        let found = work(self.gpu.as_mut()?).ok();
        if found.is_none() {
            self.gpu = None;
            self.cores.see(forest, &BTreeSet::new());
        }
        found
    }
}

impl LeafSight for GpuSight {
    fn look(&mut self, forest: &SurfelForest, positions: &[Vec3], changed: &BTreeSet<u32>) {
        let looked = self.on_gpu(forest.discs(), |gpu| {
            gpu.update(positions)?;
            if changed.is_empty() { gpu.walk() } else { gpu.walk_dragged(changed) }
        });
        if looked.is_none() {
            self.cores.see(forest.discs(), changed);
        }
    }

    fn views(&mut self, forest: &DiscForest, leaves: Range<u32>) -> Cow<'_, Views> {
        match self.on_gpu(forest, |gpu| gpu.views(leaves.clone())) {
            Some(views) => Cow::Owned(views),
            None => self.cores.views(forest, leaves),
        }
    }

    fn cuts(&mut self, forest: &DiscForest, asked: &NewCuts) -> Option<DeviceCuts> {
        let gpu = self.gpu.as_ref()?;
        // Without cuts over the environment others are shown, whose lengths stay.
        if asked.vertices.is_empty() || !asked.dataset.settings.mode.environment() {
            return None;
        }
        let directions = asked.directions(self.layout);
        let criterion = asked.criterion(directions.len());
        if !criterion.is_local(directions.len()) || !GpuForest::takes_directions(directions.len()) {
            return None;
        }
        if self.tables.is_none() {
            self.tables = Some(gpu.cut_tables(&directions));
        }
        let height = directions.len().ilog2();
        let least: Vec<u64> = (0..height).map(|depth| criterion.least_split(1 << (height - depth))).collect();
        let vertices: Vec<_> = asked.vertices.iter().map(|&vertex| (vertex, asked.is_moved(vertex))).collect();
        let stored_texels = asked.dataset.cuts.stored_texels();
        let beside = asked.beside.on_device(gpu);
        let request = CutRequest { beside, vertices: &vertices, open: asked.open, least: &least, stored_texels };
        let tables = self.tables.take()?;
        let cuts = self.on_gpu(forest, |gpu| gpu.cuts(&tables, &request));
        self.tables = Some(tables);
        cuts.flatten()
    }

    fn lights_vertices(&mut self, gloss: &Gloss, mesh: &Mesh, surfels: &[Surfel]) -> bool {
        let has_room = self.gpu.as_ref().is_some_and(|gpu| gpu.has_room_for(mesh.positions.len()));
        if gloss.is_empty() {
            self.gloss = None;
            return has_room;
        }
        let is_known = |(known, _): &(Gloss, Option<GlossTable>)| known.is_same(gloss);
        if !self.gloss.as_ref().is_some_and(is_known) {
            self.gloss = self.table_of(gloss, mesh, surfels).map(|table| (gloss.clone(), table));
        }
        has_room && self.gloss.as_ref().is_some_and(|(_, table)| table.is_some())
    }

    fn at_vertices(&mut self, forest: &DiscForest, asked: &VertexLighting) -> Option<VertexPlanes> {
        let known = self.gloss.take();
        let table = known.as_ref().and_then(|(_, table)| table.as_ref());
        let made = self.on_gpu(forest, |gpu| {
            if let Some((lighting, bounces)) = &asked.relight {
                gpu.relight(lighting, *bounces)?;
            }
            let gloss = table.zip(asked.reflection);
            if let Some((table, Reflection { eye, has_sent })) = gloss {
                let frames = &asked.gloss.frames(asked.mesh, asked.surfels);
                gpu.gloss(table, &GlossRequest { frames, eye, has_sent })?;
            }
            gpu.at_vertices(&VertexRequest {
                beside: asked.beside.on_device(gpu),
                open: asked.open.leaves(),
                states: asked.states,
                weighs_albedo: !asked.gloss.is_empty(),
                gloss: gloss.map(|(table, _)| table),
                as_baked: asked.as_baked,
            })
        });
        self.gloss = known;
        made
    }

    fn light(&mut self, forest: &DiscForest, lighting: &Lighting, bounces: u32) -> SeenLight {
        let light = self.on_gpu(forest, |gpu| gpu.light(lighting, bounces));
        light.unwrap_or_else(|| self.cores.light(forest, lighting, bounces))
    }
}
