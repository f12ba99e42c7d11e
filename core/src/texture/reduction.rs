//! Reduces a level of detail to the next.
//!
//! Sizes round down. A texel of a level covers all texels above that it overlaps, each by its share, so every level has
//! the mean of the texture for every size.

/// The size of the next level; `None` after one texel.
fn next_size([width, height]: [u32; 2]) -> Option<[u32; 2]> {
    (width > 1 || height > 1).then(|| [(width / 2).max(1), (height / 2).max(1)])
}

/// Sizes of all levels of a texture from the second on.
pub fn level_sizes(size: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    std::iter::successors(next_size(size), |&size| next_size(size))
}

/// Texels of a row of `from` that a texel of a row of `to` covers, with weights that sum to one.
fn covered(from: u32, to: u32) -> impl Fn(u32) -> Vec<(u32, f32)> {
    move |index| {
        // In units of 1 / to texels.
        let (begin, end) = (u64::from(index) * u64::from(from), u64::from(index + 1) * u64::from(from));
        let to = u64::from(to);
        (begin / to..end.div_ceil(to))
            .map(|i| (i as u32, ((end.min((i + 1) * to) - begin.max(i * to)) as f32) / from as f32))
            .collect()
    }
}

/// Calls `f` for each texel of a level, with the covered texels above and their weights.
pub(super) fn for_each_covered(from: [u32; 2], to: [u32; 2], mut f: impl FnMut(&[(usize, f32)])) {
    let (column, row) = (covered(from[0], to[0]), covered(from[1], to[1]));
    let columns: Vec<Vec<(u32, f32)>> = (0..to[0]).map(column).collect();
    let mut all = Vec::new();
    for rows in (0..to[1]).map(row) {
        for columns in &columns {
            all.clear();
            for &(y, wy) in &rows {
                all.extend(columns.iter().map(|&(x, wx)| ((y * from[0] + x) as usize, wx * wy)));
            }
            f(&all);
        }
    }
}

/// The texels of a level from the level above.
pub(super) fn reduced(texels: &[[f32; 4]], from: [u32; 2], to: [u32; 2]) -> Vec<[f32; 4]> {
    if from == to.map(|side| 2 * side) {
        return halved(texels, from[0] as usize);
    }
    let mut level = Vec::with_capacity((to[0] * to[1]) as usize);
    for_each_covered(from, to, |covered| {
        let mut sum = [0.0; 4];
        for &(i, weight) in covered {
            sum.iter_mut().zip(texels[i]).for_each(|(sum, x)| *sum += weight * x);
        }
        level.push(sum);
    });
    level
}

/// [`reduced`] for even sizes, several times as fast.
fn halved(texels: &[[f32; 4]], width: usize) -> Vec<[f32; 4]> {
    let mut level = Vec::with_capacity(texels.len() / 4);
    for rows in texels.chunks_exact(2 * width) {
        let (above, below) = rows.split_at(width);
        for (above, below) in above.as_chunks::<2>().0.iter().zip(below.as_chunks::<2>().0) {
            level.push(std::array::from_fn(|c| 0.25 * (above[0][c] + above[1][c] + below[0][c] + below[1][c])));
        }
    }
    level
}
