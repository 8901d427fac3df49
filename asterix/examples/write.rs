//! Builds and writes a CAT129 record of a drone. A value out of an item's range is an error that names the item.
//!
//!     cargo run -p utm-asterix --example write

use utm_asterix::cat129::{Altitude, GnssAccuracy, HorizontalVelocity, Position, Record, VerticalVelocity};
use utm_asterix::{BuildError, DataSource, TimeOfDay, blocks, encode_block};

/// A drone at this height above mean sea level, metres.
fn drone(altitude_m: f64) -> Result<Record, BuildError> {
    let source = DataSource { sac: 25, sic: 7 };
    let noon = TimeOfDay::from_seconds(43_200.0);
    // Mandatory items first, then the optional ones.
    Record::builder(source, *b"PL", noon, Position::new(54.5, 15.0))
        .serial_number(*b"123456784095")
        .altitude_amsl(Altitude::from_metres(altitude_m))
        .gnss_accuracy(GnssAccuracy::from_metres(3.0))
        .horizontal_velocity(HorizontalVelocity::new(12.0, -3.5))
        .vertical_velocity(VerticalVelocity::new(1.0))
        .build()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut datagram = Vec::new();
    // CAT129 allows one record per block.
    encode_block(&[drone(120.0)?], &mut datagram)?;
    encode_block(&[drone(121.5)?], &mut datagram)?;
    println!("{datagram:02x?}");

    for block in blocks(&datagram) {
        for located in block?.records::<Record>() {
            let record = located?.record;
            println!("{:?} {:?}", record.position, record.altitude_amsl);
        }
    }

    match drone(1.0e9) {
        Err(error) => println!("{error}"),
        Ok(_) => return Err("an altitude beyond the range was taken".into()),
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("nothing is wrong");
}
