#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| utm_fuzz::records::measure(34, &asterix::cat034::UAP, data));
