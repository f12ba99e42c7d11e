//! Hashes of the pixels of `.exr` files, a line per channel: equal lines mean pictures equal to the bit. Render times
//! in the metadata are not hashed. `tests/pixel_hashes.sh` compares two builds with it.

use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
use std::{env, error::Error, path::Path};

fn main() -> Result<(), Box<dyn Error>> {
    for file in env::args().skip(1) {
        let picture = Path::new(&file).file_stem().unwrap_or_default().to_string_lossy();
        for layer in read_all_flat_layers_from_file(&file)?.layer_data {
            for channel in layer.channel_data.list {
                println!("{} {picture} {}", hash(&channel.sample_data)?, channel.name);
            }
        }
    }
    Ok(())
}

/// The first 16 digits of a hash of 32-bit floats, the format that Lapidary writes.
fn hash(samples: &FlatSamples) -> Result<String, &'static str> {
    let FlatSamples::F32(values) = samples else { return Err("a channel is not of 32-bit floats") };
    Ok(blake3::hash(bytemuck::cast_slice(values)).to_hex()[..16].to_owned())
}
