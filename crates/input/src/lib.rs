//! From octets to slots: captures and gateways give datagrams, [`normalise`] makes reports of them, and [`pipeline`] passes reports
//! to the engine in the order and at the times that the configuration states.

pub mod capture;
pub mod gateways;
pub mod hex;
pub mod json;
pub mod names;
pub mod normalise;
pub mod pipeline;
pub mod statistics;
pub mod survey;
