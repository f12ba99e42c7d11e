//! Hierarchies of boxes on a device, which all rays of a scene share.

use super::{adapter::GpuDevice, buffers::storage, kernels::Hierarchy, layout};
use crate::{error::BackendError, remedy::Remedy};
use bytemuck::Zeroable;
use lapidary_core::ray::{BoxNode, HierarchyNumber, Intersector};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Most levels of a hierarchy, as in the shader.
const MOST_LEVELS: usize = 64;

/// The hierarchy of a scene on the GPU, without thin surfaces.
pub(crate) struct BoxHierarchy {
    pub nodes: wgpu::Buffer,
    pub corners: wgpu::Buffer,
    /// Both bound for programs of rays.
    pub group: wgpu::BindGroup,
}

impl BoxHierarchy {
    /// Uploads it.
    ///
    /// # Errors
    /// A hierarchy that the adapter has no room for, or a lost device.
    fn new(gpu: &GpuDevice, scene: &Intersector) -> Result<Self, BackendError> {
        let (nodes, triangles) = scene.hierarchy();
        gpu.within("the hierarchy", "levels", levels(&nodes) as u64, MOST_LEVELS as u64, Remedy::Cpu)?;
        let mut nodes: Vec<layout::BoxNode> = nodes.iter().map(packed).collect();
        let mut corners: &[f32] = bytemuck::cast_slice(triangles);
        if nodes.is_empty() {
            // A buffer has contents: a triangle without an area, which no ray crosses.
            (nodes, corners) = (vec![layout::BoxNode { triangles: 1, ..Zeroable::zeroed() }], &[0.0; 9]);
        }
        let bytes = size_of_val(corners).max(size_of_val(&nodes[..])) as u64;
        gpu.within("the triangles", "bytes", bytes, gpu.max_storage_bytes(), Remedy::Cpu)?;
        let nodes = storage(gpu, "nodes of rays", bytemuck::cast_slice(&nodes));
        let corners = storage(gpu, "triangles of rays", bytemuck::cast_slice(corners));
        let made = Self { group: Hierarchy { nodes: &nodes, corners: &corners }.bind(gpu), nodes, corners };
        gpu.check().map(|()| made)
    }
}

/// The hierarchies that something on a device uses, so that each is uploaded once.
#[derive(Clone, Default)]
pub(super) struct BoxHierarchies(Arc<Mutex<Vec<Used>>>);

/// A hierarchy while something uses it.
type Used = (HierarchyNumber, Weak<BoxHierarchy>);

impl BoxHierarchies {
    /// That of a scene: the one which is used, or a new one.
    ///
    /// # Errors
    /// A hierarchy that the adapter has no room for, or a lost device.
    pub fn get(&self, gpu: &GpuDevice, scene: &Intersector) -> Result<Arc<BoxHierarchy>, BackendError> {
        let mut used = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        used.retain(|(_, hierarchy)| hierarchy.strong_count() > 0);
        let known = used.iter().find(|(number, _)| *number == scene.number());
        if let Some(known) = known.and_then(|(_, hierarchy)| hierarchy.upgrade()) {
            return Ok(known);
        }
        let made = Arc::new(BoxHierarchy::new(gpu, scene)?);
        used.push((scene.number(), Arc::downgrade(&made)));
        Ok(made)
    }
}

fn packed(node: &BoxNode) -> layout::BoxNode {
    layout::BoxNode { low: node.min.into(), first: node.first, high: node.max.into(), triangles: node.triangles }
}

/// Levels of a hierarchy.
fn levels(nodes: &[BoxNode]) -> usize {
    let (mut deepest, mut stack) = (0, vec![(0, 1)]);
    while let Some((index, level)) = stack.pop() {
        let Some(node) = nodes.get(index as usize) else { continue };
        deepest = deepest.max(level);
        if node.triangles == 0 {
            stack.extend([(node.first, level + 1), (node.first + 1, level + 1)]);
        }
    }
    deepest
}
