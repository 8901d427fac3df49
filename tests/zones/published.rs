//! Files of authorities, of the standard, and of a test suite: each is read, or refused by name.

use std::fmt::Write;
use std::path::Path;

use utm_fusion::areas::{AreaError, Areas};
use utm_fusion::config::{AlertArea, Area, AreaKind};

/// The outcome for each file, with the ground at this height, if given.
fn outcomes(folder: &Path, ground_m: Option<f64>) -> String {
    let mut files = Vec::new();
    for sub in ["ed269", "ed318-national", "ed318-reference/examples"] {
        files.extend(std::fs::read_dir(folder.join(sub)).unwrap().map(|entry| entry.unwrap().path()));
    }
    files.sort();
    let mut table = String::new();
    for file in files {
        let kind = AreaKind::Alert(AlertArea { ground_m, ..AlertArea::default() });
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let outcome = match Areas::load(&[Area { kind, file }]) {
            Ok(areas) => format!("read: zones {}, parts {}", areas.zones().count(), areas.parts().count()),
            Err(AreaError { problem, .. }) => {
                let first: String = problem.lines().next().unwrap_or_default().chars().take(110).collect();
                format!("refused: {first}")
            }
        };
        writeln!(table, "{name}: {outcome}").unwrap();
    }
    table
}

#[test]
fn published_files_are_read_or_refused_by_name() {
    let Some(folder) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
        return;
    };
    let folder = Path::new(&folder).join("uas-zones");
    let told = outcomes(&folder, Some(500.0)) + "\nWithout ground_m:\n" + &outcomes(&folder, None);
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/zones/published.txt");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&page, &told).unwrap();
    }
    assert_eq!(told, std::fs::read_to_string(&page).unwrap());
}
