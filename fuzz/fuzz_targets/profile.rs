#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| rondure_fuzz::profile(data));
