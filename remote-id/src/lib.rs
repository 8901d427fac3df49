//! Direct Remote ID as broadcast by drones: messages of 25 octets (ASTM F3411-22a section 5.4, ASD-STAN EN 4709-002, Open
//! Drone ID), packs of messages, and the Wi-Fi and Bluetooth frames that carry them. French beacons ([`French`]) are converted
//! to packs.
//!
//! Messages can also be created: [`BasicId::new`], [`Location::new`], [`System::new`], and [`pack`] for several.
//!
//! A message keeps its octets. Methods return physical values; `None` is what the standard calls unknown. Values are not
//! checked for plausibility: a position at 0, 0 is a position.
//!
//! ```
//! use remote_id::{Message, messages};
//!
//! // A pack of one message: a drone at 45.5457468 N, 122.9681496 W with 20 m/s and course 92 degrees.
//! let octets = [
//!     0xf0, 25, 1, 0x10, 0, 92, 80, 0, 0x5c, 0x52, 0x7e, 0x1b, 0xe8, 0xa5, 0xb4, 0xb6, 0, 0, 0xaa, 9, 0x98, 8, 0x39, 0x41, 0,
//!     0, 10, 0,
//! ];
//! let Some(Ok(Message::Location(location))) = messages(&octets).next() else { panic!() };
//! assert_eq!((location.speed_m_s(), location.course_deg()), (Some(20.0), Some(92.0)));
//! ```

mod basic_id;
mod count;
mod fault;
mod frame;
mod french;
mod location;
mod message;
mod octets;
mod system;

pub use basic_id::{BasicId, IdType, UaType};
pub use fault::{Fault, NotHeard};
pub use frame::{Advertisement, Link, Listener, Transport, advertisements};
pub use french::French;
pub use location::{HeightAbove, Location, LocationContent, Status};
pub use message::{Message, Messages, OperatorId, PACK_MOST, SelfId, messages, pack};
pub use octets::LENGTH;
pub use system::{System, SystemContent};
