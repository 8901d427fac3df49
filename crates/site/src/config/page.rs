//! The reference page of all keys, `docs/CONFIGURATION.md`.

use super::{
    AdsB, AlertArea, Alerts, Area, Camera, Cluster, Conflicts, Fusion, Http, Integrity, Map, Output,
    Persistence, Radar, Sensor, Site, Transponder,
};
use tables::table::{Row, Table};

/// Beginning of the page.
const HEAD: &str = "\
# Configuration

Every key of the configuration file, written from the table of keys in `crates/site/src/config`. Do not edit this page: change the table, and
renew the page with `UPDATE=1 cargo test --test config reference_page`. [config/example.toml](../config/example.toml) shows the keys
in use, and `utm-fusion check FILE` reports every mistake and prints the configuration with all defaults.

The file is TOML. The name of a key states its unit, and an unknown key is refused. A key is overridden by the environment variable
`UTM_FUSION__SECTION__KEY`, deeper ones by further `__` (`UTM_FUSION__OUTPUT__RECORD__DIR`), except in `[[sensors]]` and `[[areas]]`.

\"Takes effect\" tells when a changed value does: with SIGHUP, while the service runs, or with a restart.
";

/// Tables of the file: title on the page, path, description, and keys.
fn tables() -> [(&'static str, &'static str, &'static str, Vec<Row>); 17] {
    fn table<T: Table>(
        name: &'static str,
        path: &'static str,
    ) -> (&'static str, &'static str, &'static str, Vec<Row>) {
        (name, path, T::ABOUT, T::rows())
    }
    [
        table::<Site>("[site]", "site"),
        table::<Sensor>("[[sensors]]", "sensors"),
        table::<Radar>("[[sensors]], radar", "sensors"),
        table::<Transponder>("[[sensors]], transponder or remote-id", "sensors"),
        table::<AdsB>("[[sensors]], adsb", "sensors"),
        table::<Camera>("[[sensors]], camera", "sensors"),
        table::<Fusion>("[fusion]", "fusion"),
        table::<Integrity>("[integrity]", "integrity"),
        table::<Conflicts>("[conflicts]", "conflicts"),
        table::<Alerts>("[alerts]", "alerts"),
        table::<Area>("[[areas]]", "areas"),
        table::<AlertArea>("[[areas]], alert", "areas"),
        table::<Output>("[output]", "output"),
        table::<Http>("[http]", "http"),
        table::<Map>("[map]", "map"),
        table::<Persistence>("[state]", "state"),
        table::<Cluster>("[cluster]", "cluster"),
    ]
}

/// Calls `each` for every row, nested ones included, with its full path below `path`.
fn flat(path: &str, rows: &[Row], is_reloaded: bool, each: &mut impl FnMut(&str, &Row, bool)) {
    for row in rows {
        let path = if path.is_empty() { row.key.to_owned() } else { format!("{path}.{}", row.key) };
        let is_reloaded = is_reloaded || row.reloaded;
        each(&path, row, is_reloaded);
        flat(&path, &row.keys, is_reloaded, each);
    }
}

/// Path of every key, such as `output.asterix.port`.
pub fn keys() -> Vec<String> {
    let mut keys = Vec::new();
    for (_, path, _, rows) in tables() {
        flat(path, &rows, false, &mut |path, _, _| keys.push(path.to_owned()));
    }
    keys
}

/// Reference page of all keys, in Markdown.
pub fn reference() -> String {
    let mut page = HEAD.to_owned();
    for (name, _, about, rows) in tables() {
        page += &format!("\n## {name}\n\n{}\n\n", about.trim());
        page += "| Key | Meaning | Values | Default | Takes effect |\n|---|---|---|---|---|\n";
        flat("", &rows, false, &mut |path, row, is_reloaded| {
            let default = row.default.as_deref().unwrap_or("needed");
            let effect = if is_reloaded { "SIGHUP" } else { "restart" };
            page += &format!("| `{path}` | {} | {} | {default} | {effect} |\n", row.about.trim(), row.values);
        });
    }
    page
}
