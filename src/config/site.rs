//! `[site]` and `[[areas]]`.

use std::path::{self, Path};

use super::reader::{Section, each};
use super::types::{Area, AreaKind, Site};

/// The site and, also where something else is wrong, its SAC and SIC.
pub(super) fn read_site(mut section: Section<'_>) -> (Option<Site>, Option<(u8, u8)>) {
    let name = section.need("name", "name = …, how the interfaces call this service").and_then(|i| i.text());
    let sac = section
        .need("sac", "sac = …, the system area code (SAC) of what the service sends")
        .and_then(|i| i.whole(0..=255u8, "a SAC is a whole number from 0 to 255"));
    let sic = section
        .need("sic", "sic = …, the system identification code (SIC) of what the service sends")
        .and_then(|i| i.whole(0..=255u8, "a SIC is a whole number from 0 to 255"));
    let geoid_undulation_m = section.item("geoid_undulation_m").and_then(|i| {
        i.number("a geoid undulation is between -120 and 100 metres; leave the key out for EGM96", |v| {
            (-120.0..=100.0).contains(&v)
        })
    });
    section.finish();
    let code = sac.zip(sic);
    let site =
        name.zip(code).map(|(name, (sac, sic))| Site { name: name.into(), sac, sic, geoid_undulation_m });
    (site, code)
}

/// The areas; `sensors` are the ids that exist, `config` is the path of the configuration file.
pub(super) fn read_areas(top: &mut Section<'_>, sensors: &[String], config: &Path) -> Option<Vec<Area>> {
    let beside = config.parent().unwrap_or(Path::new(""));
    each(top.item("areas"), |section| read_area(section, sensors, beside))
}

fn read_area(mut section: Section<'_>, sensors: &[String], beside: &Path) -> Option<Area> {
    #[derive(Clone, Copy, PartialEq)]
    enum Kind {
        Mask,
        Coverage,
        Alert,
    }
    let kind = section.need("kind", "kind = \"mask\", \"coverage\" or \"alert\"").and_then(|item| {
        item.word(&[("mask", Kind::Mask), ("coverage", Kind::Coverage), ("alert", Kind::Alert)])
    });
    let file = section.need("file", "file = …, a GeoJSON file of polygons").and_then(|item| {
        let written = beside.join(item.text()?);
        let file = path::absolute(&written).unwrap_or(written);
        if !file.is_file() {
            item.refuse(format!(
                "there is no file {}; paths are relative to the configuration file",
                file.display()
            ));
        }
        Some(file)
    });
    let kind = match kind {
        Some(Kind::Coverage) => section
            .need("sensor", "sensor = …, the id of the sensor that covers this area")
            .and_then(|item| {
                let id = item.text()?;
                if !sensors.iter().any(|known| known == id) {
                    item.refuse(format!("no sensor has this id; the sensors are: {}", sensors.join(", ")));
                }
                Some(AreaKind::Coverage { sensor: id.to_owned() })
            }),
        Some(plain) => {
            if let Some(item) = section.stray("sensor") {
                item.refuse("only an area of kind = \"coverage\" belongs to a sensor; remove the key");
            }
            Some(if plain == Kind::Mask { AreaKind::Mask } else { AreaKind::Alert })
        }
        None => {
            section.abandon();
            None
        }
    };
    section.finish();
    Some(Area { kind: kind?, file: file? })
}
