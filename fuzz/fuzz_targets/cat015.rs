#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| utm_fuzz::records::exercise_with_table::<asterix::cat015::Record>(
    data
));
