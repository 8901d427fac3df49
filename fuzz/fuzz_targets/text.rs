#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| utm_fuzz::gateways::text(data));
