//! What the tests of all panels check.

use egui_kittest::{Harness, kittest::NodeT};

/// Width in points that panels are tested at: that of a narrow inspector.
pub const WIDTH: f32 = 300.0;

/// Checks that nothing reaches past the right edge.
pub fn assert_fits<State>(panel: &Harness<State>, width: f32) {
    let nodes: Vec<_> = panel.root().children_recursive().collect();
    assert!(nodes.len() > 5, "nothing is shown");
    for node in nodes.iter().filter(|n| n.accesskit_node().raw_bounds().is_some()) {
        let rect = node.rect();
        assert!(rect.right() <= width + 1.0, "{:?} reaches {}", node.accesskit_node().label(), rect.right());
    }
}
