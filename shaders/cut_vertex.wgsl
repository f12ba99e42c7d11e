// A vertex that gets a cut on the device.
struct CutVertex {
    // Its number, and MOVED.
    number: u32,
    // The leaves beside it.
    first: u32,
    end: u32,
}

// Marks a vertex that moved, all of whose leaves count.
const MOVED: u32 = 0x80000000u;
