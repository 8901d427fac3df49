//! Writes `config/ground.pmtiles`: the invented ground of the scenarios' place, the base map of `demo --http`.
//!
//! ```sh
//! cargo run --example ground
//! ```
//!
//! Nothing of it is taken from a real map. It fits the scenarios: the aerodrome lies below the circuit, the radar beside a track,
//! the drones fly over meadows between a village, a river and a wood.

mod archive;
mod clip;
mod country;
mod feature;
mod shapes;
#[cfg(test)]
mod tests;
mod tiles;
mod village;

use std::fs;
use std::path::Path;

/// The written file, relative to the project.
const FILE: &str = "config/ground.pmtiles";

fn main() -> std::io::Result<()> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(FILE);
    let octets = octets();
    fs::write(&file, &octets)?;
    println!("{}: {} octets", file.display(), octets.len());
    Ok(())
}

/// The content of the file.
fn octets() -> Vec<u8> {
    archive::archive(&tiles::tiles(&country::features()))
}
