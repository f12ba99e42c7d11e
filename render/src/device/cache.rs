//! Compiled pipelines on disk, which the driver takes in place of compiling them again where it keeps none itself.

use super::adapter::GpuDevice;
use lapidary_core::output::write_atomically;
use std::path::{Path, PathBuf};

/// Pipelines that were compiled on an adapter, in a file of its own.
#[derive(Clone)]
pub struct PipelineCache {
    cache: wgpu::PipelineCache,
    file: PathBuf,
}

impl PipelineCache {
    /// What a device must have for it.
    pub const FEATURES: wgpu::Features = wgpu::Features::PIPELINE_CACHE;

    /// The cache of an adapter in a folder; `None` where its driver hands out no pipelines. A file that this program did not write as it
    /// is, is ignored.
    pub fn open(device: &wgpu::Device, info: &wgpu::AdapterInfo, folder: &Path) -> Option<Self> {
        if !device.features().contains(Self::FEATURES) {
            return None;
        }
        let file = folder.join(wgpu::util::pipeline_cache_key(info)?);
        let known = std::fs::read(&file).ok();
        let data = known.as_deref().and_then(content);
        let descriptor = wgpu::PipelineCacheDescriptor { label: Some("pipelines"), data, fallback: true };
        // SAFETY: the data are what `get_data` returned to `save`, by their checksum. wgpu and the driver refuse those of another driver.
        let cache = unsafe { device.create_pipeline_cache(&descriptor) };
        Some(Self { cache, file })
    }

    /// Writes what was compiled. Without it the next start takes longer, so that a full disk is no error.
    pub fn save(&self) {
        let Some(data) = self.cache.get_data() else { return };
        let written = [blake3::hash(&data).as_bytes(), &data[..]].concat();
        if std::fs::read(&self.file).is_ok_and(|known| known == written) {
            return;
        }
        let _ = self.file.parent().map(std::fs::create_dir_all);
        let _ = write_atomically(&self.file, &written);
    }
}

/// What a file holds after its checksum, if that is right.
fn content(file: &[u8]) -> Option<&[u8]> {
    let (sum, data) = file.split_at_checked(blake3::OUT_LEN)?;
    (blake3::hash(data).as_bytes() == sum).then_some(data)
}

impl GpuDevice {
    /// Where pipelines are looked for before they are compiled.
    pub fn pipeline_cache(&self) -> Option<&wgpu::PipelineCache> {
        self.pipelines.as_ref().map(|pipelines| &pipelines.cache)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{Room, Shaders, kernel::Kernel, kernels::RADIOSITY_SCAN, test_adapter::on_adapter};

    /// With a pipeline compiled by the cache of a folder.
    fn device(folder: &Path) -> Option<GpuDevice> {
        let (_one_at_a_time, gpu) = on_adapter(|| GpuDevice::with_cache(Room::Defaults, Some(folder)))?;
        Kernel::new(&gpu, &Shaders::default(), &RADIOSITY_SCAN, &[]).expect("it compiles");
        Some(gpu)
    }

    #[test]
    fn pipelines_are_kept_in_a_file_and_a_broken_one_is_made_anew() {
        let folder = tempfile::tempdir().unwrap();
        let Some(gpu) = device(folder.path()) else { return };
        let Some(pipelines) = &gpu.pipelines else { return };
        let Some(data) = pipelines.cache.get_data() else { return };
        pipelines.save();
        let file = std::fs::read(&pipelines.file).unwrap();
        assert_eq!(content(&file), Some(&data[..]));
        for damage in [0, blake3::OUT_LEN, file.len() - 1] {
            let mut broken = file.clone();
            broken[damage] ^= 1;
            assert_eq!(content(&broken), None, "negative control");
        }
        assert_eq!(content(&file[..blake3::OUT_LEN - 1]), None);
        drop(gpu);
        let path = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
        std::fs::write(&path, b"no pipelines").unwrap();
        let gpu = device(folder.path()).unwrap();
        gpu.pipelines.iter().for_each(PipelineCache::save);
        assert!(content(&std::fs::read(&path).unwrap()).is_some());
    }
}
