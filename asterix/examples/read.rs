//! Reads a datagram with radar plots and service messages, and with a fault that affects only its own block.
//!
//!     cargo run -p utm-asterix --example read

use utm_asterix::cat034::MessageType;
use utm_asterix::{Fault, Record, blocks, cat034, cat048};

/// A north marker, two plots, and a truncated block.
const DATAGRAM: &[u8] = &[
    0x22, 0x00, 0x0a, 0xe0, 0x19, 0x07, 0x01, 0x54, 0x60, 0x00, // CAT034: 010, 000, 030
    0x30, 0x00, 0x1d, // CAT048
    0xf1, 0x10, 0x19, 0x07, 0x54, 0x60, 0x40, 0x20, 0x01, 0x00, 0x40, 0x00, 0x00,
    0x07, // 010, 140, 020, 040, 161
    0x90, 0x19, 0x07, 0x02, 0x00, 0x80, 0x00, // 010, 040
    0x90, 0x19, 0x07, 0x02, 0x00, // 010, and a part of 040
];

fn main() -> Result<(), Fault> {
    for block in blocks(DATAGRAM) {
        let block = block?;
        match block.category {
            cat034::Record::CATEGORY => {
                for located in block.records::<cat034::Record>() {
                    let record = located?.record;
                    let kind = record.message_type.map(MessageType::kind);
                    println!("{:?}: {kind:?}", record.data_source);
                }
            }
            cat048::Record::CATEGORY => {
                for located in block.records::<cat048::Record>() {
                    match located {
                        Ok(located) => print(&located.record),
                        // The records before the fault are valid; reading continues with the next block.
                        Err(fault) => println!("{fault}"),
                    }
                }
            }
            other => println!("CAT{other:03} is not looked into"),
        }
    }
    Ok(())
}

fn print(record: &cat048::Record) {
    let Some(position) = record.polar_position else { return };
    match record.track_number {
        Some(track) => print!("track {}: ", track.number()),
        None => print!("plot: "),
    }
    println!("{:.0} m at {:.1} degrees", position.range_m(), position.azimuth_deg());
}

#[test]
fn it_runs() {
    main().expect("nothing is wrong");
}
