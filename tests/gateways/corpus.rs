//! The corpus of the translators' fuzz targets (`fuzz/corpus`), run through these targets.

use std::path::Path;

#[path = "../../fuzz/src/gateways.rs"]
mod gateways;

#[test]
fn fuzz_corpus_of_each_target_passes() {
    type Target = (&'static str, fn(&[u8]));
    let targets: [Target; 4] = [
        ("adsb", gateways::adsb),
        ("mavlink", gateways::mavlink),
        ("remote_id", gateways::remote_id),
        ("text", gateways::text),
    ];
    for (target, exercise) in targets {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
        let mut count = 0;
        for file in std::fs::read_dir(folder).unwrap() {
            let octets = std::fs::read(file.unwrap().path()).unwrap();
            exercise(&octets);
            // Every prefix of it, and every octet changed.
            (0..octets.len()).for_each(|length| exercise(&octets[..length]));
            for at in 0..octets.len() {
                let mut damaged = octets.clone();
                damaged[at] ^= 0x55;
                exercise(&damaged);
            }
            count += 1;
        }
        assert!(count > 0, "{target}");
    }
}
