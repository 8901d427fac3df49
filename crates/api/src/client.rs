//! Address of a request's client: the peer of the connection, or the address reported by a trusted reverse proxy.

use std::net::{IpAddr, Ipv6Addr, SocketAddr};

use axum::http::{HeaderMap, header};

use site::config::Network;

/// Address of the peer of a connection.
#[derive(Clone, Copy, Debug)]
pub struct PeerAddress(pub IpAddr);

/// Unit for counting connections, streams and requests: an IPv4 address, or a /64 network of IPv6, the usual allocation of one
/// subscriber.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Subscriber(IpAddr);

impl Subscriber {
    /// Subscriber that an address belongs to.
    pub fn at(address: IpAddr) -> Self {
        Self(match address.to_canonical() {
            IpAddr::V6(v6) => Ipv6Addr::from_bits(v6.to_bits() >> 64 << 64).into(),
            v4 => v4,
        })
    }
}

/// Address of the client: the right-most reported address that is not a trusted proxy. If none is reported or one is unreadable,
/// the address of the proxy that reported it.
///
/// `X-Forwarded-For` and `Forwarded` (RFC 7239) are trusted from trusted proxies only. Most proxies write one of them and pass
/// the other on unchanged from the client. If both are present and differ, neither is trusted.
pub fn client(peer: IpAddr, headers: &HeaderMap, trusted: &[Network]) -> IpAddr {
    if !is_trusted(peer, trusted) {
        return peer;
    }
    let farthest = |hops: Option<Vec<Option<IpAddr>>>| hops.map(|hops| walk(peer, &hops, trusted));
    match (farthest(x_forwarded_for(headers)), farthest(forwarded(headers))) {
        (Some(one), Some(other)) if one != other => peer,
        (Some(client), _) | (None, Some(client)) => client,
        (None, None) => peer,
    }
}

/// Whether the address is a trusted proxy.
pub fn is_trusted(address: IpAddr, trusted: &[Network]) -> bool {
    trusted.iter().any(|network| network.contains(address))
}

/// Follows the hops from the nearest one outwards, as long as trusted proxies report them.
fn walk(peer: IpAddr, hops: &[Option<IpAddr>], trusted: &[Network]) -> IpAddr {
    let mut client = peer;
    for hop in hops.iter().rev() {
        // An unreadable hop hides all hops beyond it.
        let Some(hop) = *hop else { break };
        client = hop;
        if !is_trusted(hop, trusted) {
            break;
        }
    }
    client
}

/// Hops of `X-Forwarded-For`, farthest first; `None` without this header.
fn x_forwarded_for(headers: &HeaderMap) -> Option<Vec<Option<IpAddr>>> {
    let lines = lines(headers, &header::HeaderName::from_static("x-forwarded-for"))?;
    Some(lines.split(',').map(|hop| address(hop.trim())).collect())
}

/// Hops of `Forwarded`, farthest first; `None` without this header.
fn forwarded(headers: &HeaderMap) -> Option<Vec<Option<IpAddr>>> {
    let lines = lines(headers, &header::FORWARDED)?;
    Some(split(&lines, ',').map(node).collect())
}

/// Joins the lines of a repeated header into one list. A line that is not text counts as an unreadable hop.
fn lines(headers: &HeaderMap, name: &header::HeaderName) -> Option<String> {
    let lines: Vec<&str> =
        headers.get_all(name).iter().map(|line| line.to_str().unwrap_or("unknown")).collect();
    (!lines.is_empty()).then(|| lines.join(","))
}

/// Address in `for=` of an element such as `for="[2001:db8::1]:4711";proto=https`.
fn node(element: &str) -> Option<IpAddr> {
    let value = split(element, ';').find_map(|pair| {
        let (name, value) = pair.split_once('=')?;
        name.trim().eq_ignore_ascii_case("for").then_some(value)
    })?;
    // Addresses contain no characters that need escapes.
    address(value.trim().trim_matches('"'))
}

/// Address with or without a port; IPv6 with or without brackets. `None` for `unknown` and for names.
fn address(text: &str) -> Option<IpAddr> {
    let bare = text.strip_prefix('[').and_then(|text| text.strip_suffix(']')).unwrap_or(text);
    let address: Option<IpAddr> = bare.parse().ok();
    let address = address.or_else(|| text.parse().ok().map(|address: SocketAddr| address.ip()));
    address.map(|address| address.to_canonical())
}

/// Parts between separators outside quotes.
fn split(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut is_quoted = false;
    text.split(move |c| {
        is_quoted ^= c == '"';
        c == separator && !is_quoted
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn of(peer: &str, headers: &[(&'static str, &str)]) -> String {
        let trusted: Vec<Network> =
            ["127.0.0.1", "10.0.0.0/8", "fd00::/8"].map(|network| network.parse().unwrap()).to_vec();
        let mut map = HeaderMap::new();
        for (name, value) in headers {
            map.append(*name, value.parse().unwrap());
        }
        client(peer.parse().unwrap(), &map, &trusted).to_string()
    }

    #[test]
    fn client_is_nearest_untrusted_address() {
        const XFF: &str = "x-forwarded-for";
        const FORWARDED: &str = "forwarded";
        for (peer, headers, client) in [
            // Headers from other peers are not trusted.
            ("192.0.2.1", &[(XFF, "198.51.100.7")][..], "192.0.2.1"),
            ("127.0.0.1", &[], "127.0.0.1"),
            ("127.0.0.1", &[(XFF, "198.51.100.7")], "198.51.100.7"),
            // The client's own entries are further left.
            ("127.0.0.1", &[(XFF, "203.0.113.9, 198.51.100.7, 10.1.1.1")], "198.51.100.7"),
            ("127.0.0.1", &[(XFF, "203.0.113.9"), (XFF, "198.51.100.7")], "198.51.100.7"),
            ("127.0.0.1", &[(XFF, "10.0.0.9, 10.0.0.8")], "10.0.0.9"),
            ("127.0.0.1", &[(XFF, "198.51.100.7:4711")], "198.51.100.7"),
            ("127.0.0.1", &[(XFF, "[2001:db8::7]:4711")], "2001:db8::7"),
            ("fd00::1", &[(XFF, "::ffff:198.51.100.7")], "198.51.100.7"),
            // The proxy does not report the client, so the nearest known address is used.
            ("127.0.0.1", &[(XFF, "198.51.100.7, unknown, 10.0.0.9")], "10.0.0.9"),
            ("127.0.0.1", &[(XFF, "")], "127.0.0.1"),
            ("127.0.0.1", &[(FORWARDED, "for=198.51.100.7;proto=https;by=10.0.0.1")], "198.51.100.7"),
            ("127.0.0.1", &[(FORWARDED, "For=\"[2001:db8::7]:4711\"; host=\"a,b\"")], "2001:db8::7"),
            ("127.0.0.1", &[(FORWARDED, "for=203.0.113.9, for=198.51.100.7, for=10.0.0.9")], "198.51.100.7"),
            ("127.0.0.1", &[(FORWARDED, "for=198.51.100.7, for=_hidden")], "127.0.0.1"),
            ("127.0.0.1", &[(FORWARDED, "for=198.51.100.7, proto=http")], "127.0.0.1"),
            // One of the two headers comes from the client.
            ("127.0.0.1", &[(XFF, "198.51.100.7"), (FORWARDED, "for=203.0.113.9")], "127.0.0.1"),
            ("127.0.0.1", &[(XFF, "198.51.100.7"), (FORWARDED, "for=198.51.100.7")], "198.51.100.7"),
        ] {
            assert_eq!(of(peer, headers), client, "{peer} {headers:?}");
        }
    }

    #[test]
    fn ipv6_addresses_of_a_64_prefix_are_one_client() {
        let of = |text: &str| Subscriber::at(text.parse().unwrap());
        assert_eq!(of("2001:db8::1"), of("2001:db8::ffff:1"));
        assert_ne!(of("2001:db8::1"), of("2001:db8:0:1::1"));
        assert_ne!(of("192.0.2.1"), of("192.0.2.2"));
        assert_eq!(of("::ffff:192.0.2.1"), of("192.0.2.1"));
    }

    proptest! {
        /// Any text that the client puts before the proxy's entry.
        #[test]
        fn forged_forwarding_header_is_ignored(written in "[ -~]{0,60}") {
            let appended = format!("{written}, 198.51.100.7");
            prop_assert_eq!(of("127.0.0.1", &[("x-forwarded-for", &appended)]), "198.51.100.7");
            // An open quote swallows the proxy's entry: then no client is found, and never a false one.
            let appended = format!("{written}, for=198.51.100.7");
            let client = of("127.0.0.1", &[("forwarded", &appended)]);
            let is_even = written.matches('"').count() % 2 == 0;
            prop_assert!(client == "198.51.100.7" || !is_even && client == "127.0.0.1", "{client}");
        }
    }
}
