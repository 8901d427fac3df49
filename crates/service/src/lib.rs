//! The live service without HTTP: sockets in, a picture for each slot on time, and what accompanies it: requests of operators,
//! alerts, recordings, history, state that outlives a restart, and delivery to receivers.

pub mod clock;
pub mod current;
pub mod history;
pub mod integrity;
pub mod live;
pub mod net;
pub mod notices;
pub mod record;
pub mod sinks;
pub mod state;
