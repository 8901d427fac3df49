//! Reads a category without types by its public definition: items with number, name and layout, fields with key and value.
//!
//!     cargo run -p utm-asterix --features all --example untyped

use utm_asterix::{Kind, Layout, all, blocks};

/// CAT010 (surface movement): 010 data source, 000 message type, 140 time of day, 042 Cartesian position.
const DATAGRAM: &[u8] = &[0x0a, 0x00, 0x0e, 0xd2, 0x19, 0x07, 0x01, 0x54, 0x60, 0x00, 0x00, 0x64, 0xff, 0x9c];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for block in blocks(DATAGRAM) {
        let block = block?;
        let category = all::category(block.category).ok_or("a category without a public definition")?;
        let definition = category.newest();
        println!("CAT{:03}, edition {}", definition.category(), definition.edition());
        for located in definition.records(block) {
            for (item, octets) in located?.record.items() {
                println!("  {} {}: {octets:02x?}", item.item, item.name);
                let Layout::Fields(fields) = item.layout else { continue };
                let mut at = 0;
                for field in fields {
                    let count = field.count(octets, at);
                    match field.kind {
                        Kind::Quantity(quantity) => {
                            println!(
                                "    {:?}: {}",
                                field.key,
                                quantity.value(count, usize::from(field.bits))
                            );
                        }
                        _ => println!("    {:?}: {count}", field.key),
                    }
                    at += usize::from(field.bits);
                }
            }
        }
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().expect("nothing is wrong");
}
