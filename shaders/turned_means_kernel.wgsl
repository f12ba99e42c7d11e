// Means up a tree of lights, by up to eight levels. Twin of `means_up_the_tree` in core/src/light_tree.rs.

@group(1) @binding(0) var<uniform> level: MeansUniforms;
@group(1) @binding(1) var<storage, read_write> means: array<Means>;

struct MeansUniforms {
    // Parents of the nodes whose means are known.
    parents: u32,
}

// Parents of a workgroup.
const PARENTS: u32 = 128u;

var<workgroup> known: array<Means, PARENTS>;

@compute @workgroup_size(128)
fn average(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = workgroup_number(group);
    // In a level each node has the number of nodes in it plus its place.
    var in_level = level.parents;
    var in_group = min(PARENTS, in_level);
    if lane < in_group {
        let node = in_level + PARENTS * number + lane;
        keep(lane, node, mean_of(means[2u * node], means[2u * node + 1u]));
    }
    while in_group > 1u {
        in_level /= 2u;
        in_group /= 2u;
        var mean = Means();
        workgroupBarrier();
        if lane < in_group {
            mean = mean_of(known[2u * lane], known[2u * lane + 1u]);
        }
        workgroupBarrier();
        if lane < in_group {
            keep(lane, in_level + in_group * number + lane, mean);
        }
    }
}

fn mean_of(left: Means, right: Means) -> Means {
    return Means(
        (left.radiance + right.radiance) * 0.5,
        (left.luminance_sq + right.luminance_sq) * 0.5,
        (left.weighted + right.weighted) * 0.5,
        (left.luminance + right.luminance) * 0.5,
    );
}

// Node 0 repeats the root.
fn keep(lane: u32, node: u32, mean: Means) {
    known[lane] = mean;
    means[node] = mean;
    if node == 1u {
        means[0] = mean;
    }
}
