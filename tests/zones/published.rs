//! The files of authorities, of the standard, and of a test suite: each is read, or refused by name.

use std::fmt::Write;

use super::*;

/// What comes of each file with the ground at that height, where it is known.
fn outcomes(folder: &std::path::Path, ground_m: Option<f64>) -> String {
    let mut files = Vec::new();
    for sub in ["ed269", "ed318-national", "ed318-reference/examples"] {
        for entry in std::fs::read_dir(folder.join(sub)).unwrap() {
            files.push(entry.unwrap().path());
        }
    }
    files.sort();
    let mut table = String::new();
    for file in files {
        let kind = AreaKind::Alert(AlertArea { ground_m, ..AlertArea::default() });
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let outcome = match Areas::load(&[Area { kind, file }]) {
            Ok(areas) => format!("{} zones, {} parts", areas.zones().count(), areas.parts().count()),
            Err(AreaError { problem, .. }) => problem.lines().next().unwrap().chars().take(100).collect(),
        };
        writeln!(table, "{name}: {outcome}").unwrap();
    }
    table
}

#[test]
fn published_files_are_read_or_refused_by_name() {
    let Some(folder) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        eprintln!("skipped: UTM_FUSION_SHARED_DATA is not set");
        return;
    };
    let folder = PathBuf::from(folder).join("uas-zones");
    assert_eq!(outcomes(&folder, Some(500.0)), include_str!("published.txt"));
    let without = outcomes(&folder, None);
    assert_eq!(
        without.matches("add ground_m").count() + without.matches("counted from the ground").count(),
        0,
        "{without}"
    );
}
