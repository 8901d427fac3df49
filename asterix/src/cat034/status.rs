//! Status of the radar: I034/050, 060.

use crate::item::items;

items! {
    /// I034/050 (5.2.6), system configuration and status.
    compound pub struct SystemStatus {
        /// COM, common part.
        "com" common: CommonStatus,
        _,
        _,
        /// PSR, the primary radar.
        "psr" psr: SensorStatus,
        /// SSR, the secondary radar.
        "ssr" ssr: SensorStatus,
        /// MDS, the Mode S radar.
        "mds" mode_s: ModeSStatus,
        _,
    }

    /// COM in I034/050.
    pub struct CommonStatus(1) {
        /// NOGO: not released for operational use; its data must be discarded.
        flag 1 "nogo" is_nogo / with_nogo;
        /// RDPC: radar data processor chain 2 is selected; not set: chain 1.
        flag 1 "rdpc" is_chain_2 / with_chain_2;
        /// RDPR: the processor chain restarts; track numbers will be assigned again.
        flag 1 "rdpr" is_reset / with_reset;
        /// OVL RDP: the radar data processor is overloaded.
        flag 1 "ovl_rdp" is_processor_overloaded / with_processor_overloaded;
        /// OVL XMT: the transmission subsystem is overloaded.
        flag 1 "ovl_xmt" is_transmission_overloaded / with_transmission_overloaded;
        /// MSC: the monitoring system is disconnected.
        flag 1 "msc" is_monitor_disconnected / with_monitor_disconnected;
        /// TSV: the time source is invalid.
        flag 1 "tsv" is_time_invalid / with_time_invalid;
        spare 1 "spare";
    }

    /// CH-A/B in I034/050: the channels in use.
    pub enum Channels {
        /// no channel.
        None = 0,
        /// channel A only.
        A = 1,
        /// channel B only.
        B = 2,
        /// both (diversity); not valid for a secondary or Mode S radar.
        Both = 3,
    }

    /// PSR and SSR in I034/050.
    pub struct SensorStatus(1) {
        /// ANT: antenna 2 is selected; not set: antenna 1.
        flag 1 "ant" is_antenna_2 / with_antenna_2;
        /// CH-A/B, the channels in use.
        code 2 "chab" channels / with_channels: Channels;
        /// OVL: overloaded.
        flag 1 "ovl" is_overloaded / with_overloaded;
        /// MSC: the monitoring system is disconnected.
        flag 1 "msc" is_monitor_disconnected / with_monitor_disconnected;
        spare 3 "spare";
    }

    /// MDS in I034/050.
    pub struct ModeSStatus(2) {
        /// ANT: antenna 2 is selected; not set: antenna 1.
        flag 1 "ant" is_antenna_2 / with_antenna_2;
        /// CH-A/B, the channels in use.
        code 2 "chab" channels / with_channels: Channels;
        /// OVL SUR: overloaded.
        flag 1 "ovl_sur" is_overloaded / with_overloaded;
        /// MSC: the monitoring system is disconnected.
        flag 1 "msc" is_monitor_disconnected / with_monitor_disconnected;
        /// SCF: channel B performs the surveillance co-ordination function; not set: channel A.
        flag 1 "scf" is_co_ordination_on_b / with_co_ordination_on_b;
        /// DLF: channel B performs the data link function; not set: channel A.
        flag 1 "dlf" is_data_link_on_b / with_data_link_on_b;
        /// OVL SCF: the surveillance co-ordination function is overloaded.
        flag 1 "ovl_scf" is_co_ordination_overloaded / with_co_ordination_overloaded;
        /// OVL DLF: the data link function is overloaded.
        flag 1 "ovl_dlf" is_data_link_overloaded / with_data_link_overloaded;
        spare 7 "spare";
    }

    /// I034/060 (5.2.7), system processing mode.
    compound pub struct SystemMode {
        /// COM, common part.
        "com" common: CommonMode,
        _,
        _,
        /// PSR, the primary radar.
        "psr" psr: PsrMode,
        /// SSR, the secondary radar.
        "ssr" ssr: SsrMode,
        /// MDS, the Mode S radar.
        "mds" mode_s: ModeSMode,
        _,
    }

    /// COM in I034/060.
    pub struct CommonMode(1) {
        spare 1 "spare";
        /// RED RDP, step of load reduction in the radar data processor: 0 none, to 7.
        count 3 "red_rdp" processor_reduction / with_processor_reduction: u8;
        /// RED XMT, step of load reduction in the transmission subsystem: 0 none, to 7.
        count 3 "red_xmt" transmission_reduction / with_transmission_reduction: u8;
        spare 1 "spare_2";
    }

    /// PSR in I034/060.
    pub struct PsrMode(1) {
        /// POL: circular polarisation; not set: linear.
        flag 1 "pol" is_circular / with_circular;
        /// RED RAD, step of load reduction in the PSR: 0 none, to 7.
        count 3 "red_rad" reduction / with_reduction: u8;
        /// STC, number of the sensitivity time control map minus 1, 0 to 3.
        count 2 "stc" sensitivity_map / with_sensitivity_map: u8;
        spare 2 "spare";
    }

    /// SSR in I034/060.
    pub struct SsrMode(1) {
        /// RED RAD, step of load reduction in the SSR: 0 none, to 7.
        count 3 "red_rad" reduction / with_reduction: u8;
        spare 5 "spare";
    }

    /// MDS in I034/060.
    pub struct ModeSMode(1) {
        /// RED RAD, step of load reduction in the Mode S radar: 0 none, to 7.
        count 3 "red_rad" reduction / with_reduction: u8;
        /// CLU: part of a cluster; not set: autonomous.
        flag 1 "clu" is_in_cluster / with_in_cluster;
        spare 4 "spare";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_status() {
        let status = CommonStatus::from_octets([0xa2]);
        assert!(status.is_nogo() && status.is_reset() && status.is_time_invalid());
        assert!(!status.is_chain_2() && !status.is_processor_overloaded());
        assert!(!status.is_transmission_overloaded() && !status.is_monitor_disconnected());
        assert_eq!(CommonStatus::default().with_transmission_overloaded(true).octets(), [0x08]);
    }

    #[test]
    fn sensors() {
        assert_eq!(SensorStatus::from_octets([0x70]).channels(), Channels::Both);
        let status = ModeSStatus::default().with_channels(Channels::B).with_data_link_overloaded(true);
        assert_eq!(status.octets(), [0x40, 0x80]);
        assert_eq!(PsrMode::from_octets([0xd4]).sensitivity_map(), 1);
        assert_eq!(CommonMode::from_octets([0x5a]).processor_reduction(), 5);
        assert_eq!(CommonMode::from_octets([0x5a]).transmission_reduction(), 5);
        assert!(ModeSMode::from_octets([0x10]).is_in_cluster());
    }
}
