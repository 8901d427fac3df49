//! IP networks in an operator's notation: `10.0.0.0/8`, `2001:db8::/32`, or a single address.

use std::fmt::{self, Display, Formatter};
use std::net::IpAddr;
use std::str::FromStr;

use tables::kinds::Toml;
use tables::tree::quoted;

/// Addresses that share their leading bits with this one. An IPv4-mapped IPv6 address counts as the IPv4 address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Network {
    address: IpAddr,
    bits: u32,
}

/// Reason why a text is not a [`Network`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotANetwork {
    /// The text is neither an address nor a network.
    #[error(
        "expected an address such as \"127.0.0.1\" or a network such as \"10.0.0.0/8\"; names are not looked up"
    )]
    Unreadable,
    /// The prefix is longer than an address of this family, or zero.
    #[error("an IPv4 network has /1 to /32, an IPv6 network /1 to /128")]
    Bits,
    /// The address has bits set beyond the prefix.
    #[error("the address has bits set beyond /{0}; the network is \"{1}\"")]
    Beyond(u32, Network),
}

impl Network {
    /// Whether the network contains `address`.
    pub fn contains(&self, address: IpAddr) -> bool {
        let address = address.to_canonical();
        address.is_ipv4() == self.address.is_ipv4() && masked(address, self.bits) == self.address
    }
}

/// `address` with all but its leading `bits` cleared.
fn masked(address: IpAddr, bits: u32) -> IpAddr {
    match address {
        IpAddr::V4(v4) => IpAddr::V4((v4.to_bits() & u32::MAX.unbounded_shl(32 - bits)).into()),
        IpAddr::V6(v6) => IpAddr::V6((v6.to_bits() & u128::MAX.unbounded_shl(128 - bits)).into()),
    }
}

fn width(address: IpAddr) -> u32 {
    if address.is_ipv4() { 32 } else { 128 }
}

impl Toml for Network {
    fn toml(&self) -> Option<String> {
        Some(quoted(&self.to_string()))
    }
}

impl FromStr for Network {
    type Err = NotANetwork;

    fn from_str(text: &str) -> Result<Self, NotANetwork> {
        let (address, bits) = text.split_once('/').map_or((text, None), |(at, bits)| (at, Some(bits)));
        let address: IpAddr = address.parse().map_err(|_| NotANetwork::Unreadable)?;
        let Some(bits) = bits else {
            let address = address.to_canonical();
            return Ok(Self { address, bits: width(address) });
        };
        let bits: u32 = bits.parse().map_err(|_| NotANetwork::Unreadable)?;
        // /0 would match every address.
        if !(1..=width(address)).contains(&bits) {
            return Err(NotANetwork::Bits);
        }
        let network = Self { address: masked(address, bits), bits };
        if network.address == address { Ok(network) } else { Err(NotANetwork::Beyond(bits, network)) }
    }
}

/// Writes the network as it is read; a single address has no `/`.
impl Display for Network {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.address)?;
        if self.bits == width(self.address) { Ok(()) } else { write!(f, "/{}", self.bits) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_network_holds_its_addresses_and_reads_back() {
        for (text, inside, outside) in [
            ("10.0.0.0/8", "10.255.0.1", "11.0.0.0"),
            ("127.0.0.1", "127.0.0.1", "127.0.0.2"),
            ("192.0.2.128/25", "192.0.2.200", "192.0.2.127"),
            ("2001:db8::/32", "2001:db8:ffff::1", "2001:db9::"),
            ("::1", "::1", "::2"),
            ("10.0.0.0/8", "::ffff:10.1.2.3", "::10.1.2.3"),
        ] {
            let network: Network = text.parse().unwrap();
            assert!(network.contains(inside.parse().unwrap()), "{text} {inside}");
            assert!(!network.contains(outside.parse().unwrap()), "{text} {outside}");
            assert_eq!(network.to_string(), text);
        }
    }

    #[test]
    fn invalid_network_is_refused_with_reason() {
        for text in ["", "proxy", "10.0.0.0/x", "10.0.0.0:80", "/8"] {
            assert_eq!(text.parse::<Network>(), Err(NotANetwork::Unreadable), "{text}");
        }
        for text in ["0.0.0.0/0", "10.0.0.0/33", "::/0", "::/129"] {
            assert_eq!(text.parse::<Network>(), Err(NotANetwork::Bits), "{text}");
        }
        let error = "10.1.2.3/8".parse::<Network>().unwrap_err().to_string();
        assert!(error.ends_with("the network is \"10.0.0.0/8\""), "{error}");
    }
}
