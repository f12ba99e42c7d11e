//! Bakes on devices.

use super::*;
use crate::test_devices::Emulated;

#[test]
fn a_bake_on_a_device_is_that_of_the_cores() {
    let folder = tempfile::tempdir().unwrap();
    let cores = bake(scene(), &job(folder.path(), "cores.cuts"), &Silent).unwrap();
    let baked_on = |devices: &Emulated, name| {
        let baked = bake_on(scene(), &job(folder.path(), name), Some(devices), &Silent).unwrap();
        assert!(baked.report.on_device && devices.begun() > 0);
        baked
    };
    let device = baked_on(&Emulated::lasting(), "device.cuts");
    assert_eq!(contents(&device), contents(&cores));
    let told = |of: &Dataset| (of.report.audit, of.report.rays_traced);
    assert!(told(&device) == told(&cores) && told(&cores).0.is_some(), "also along boundaries, and in the audit");
    assert!(!cores.report.on_device);
    let other = baked_on(&Emulated::blind(), "blind.cuts");
    assert_ne!(contents(&other), contents(&cores), "negative control: a device that sees nothing");
    assert_ne!(told(&other), told(&cores), "negative control");
}
