//! End-to-end tests over the built program, a file a subject, in one binary, which is linked once.

mod animations;
mod bad_input;
mod baking;
mod bounces;
mod common;
mod crosscheck;
mod evidence;
mod explain;
mod export;
mod farm;
mod faults;
mod gpu;
mod info;
mod kills;
mod looks;
mod materials;
mod mitsuba;
mod outputs;
mod outside;
mod pictures;
mod poses;
mod reproducers;
mod wavelet;
