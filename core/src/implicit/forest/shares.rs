//! Number of surfels per object.

/// Smallest number of surfels per object, unless there are too many objects.
const LEAST: u32 = 64;

/// Shares `total` surfels among objects by their areas in m². Each object with an area has at least 64. If that takes more than
/// half of them, the minimum is what half of them allows, but at least one. Only then does the sum exceed `total`.
pub fn shares(areas: &[f64], total: u32) -> Vec<u32> {
    let objects = areas.iter().filter(|&&area| area > 0.0).count() as u32;
    let least = (total / 2 / objects.max(1)).clamp(1, LEAST);
    let mut all: Vec<u32> = areas.iter().map(|&area| if area > 0.0 { least } else { 0 }).collect();
    let mut left = total.saturating_sub(objects * least);
    // Large objects get their fair share of the whole; the largest gets the remainder from rounding.
    let fair = fair_share(areas, total, least);
    for (share, area) in all.iter_mut().zip(areas) {
        let more = ((area * fair) as u32).saturating_sub(*share).min(left);
        (*share, left) = (*share + more, left - more);
    }
    let largest = (0..areas.len()).max_by(|&a, &b| areas[a].total_cmp(&areas[b]).then(b.cmp(&a)));
    if let Some(largest) = largest.filter(|_| objects > 0) {
        all[largest] += left;
    }
    all
}

/// Surfels per m² of the objects above the minimum.
fn fair_share(areas: &[f64], total: u32, least: u32) -> f64 {
    let mut ascending: Vec<f64> = areas.iter().copied().filter(|&area| area > 0.0).collect();
    ascending.sort_unstable_by(f64::total_cmp);
    let (mut area, mut surfels) = (ascending.iter().sum::<f64>(), f64::from(total));
    for small in ascending {
        if small * surfels >= f64::from(least) * area {
            return surfels / area;
        }
        (area, surfels) = (area - small, (surfels - f64::from(least)).max(0.0));
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_go_by_area_above_a_least_number() {
        assert_eq!(shares(&[1.0, 3.0], 4096), [1024, 3072]);
        assert_eq!(shares(&[1e-6, 0.0, 3.0, 1.0], 4096), [64, 0, 3024, 1008]);
        let thirds = shares(&[1.0, 1.0, 1.0], 4096);
        assert_eq!((thirds.iter().sum::<u32>(), thirds[1]), (4096, 1365));
        assert_eq!(shares(&[], 4096), [0; 0]);
        assert_eq!(shares(&[0.0], 4096), [0]);
    }

    #[test]
    fn many_objects_have_fewer_each_but_never_none() {
        let many = shares(&vec![1.0; 256], 4096);
        assert!(many.iter().all(|&n| n >= 8) && many.iter().sum::<u32>() == 4096);
        let one_large: Vec<f64> = (0..256).map(|i| if i == 7 { 1e6 } else { 1.0 }).collect();
        assert_eq!((shares(&one_large, 4096)[7], shares(&one_large, 4096)[8]), (4096 - 255 * 8, 8));
        assert_eq!(shares(&vec![1.0; 5000], 4096).iter().sum::<u32>(), 5000);
    }
}
