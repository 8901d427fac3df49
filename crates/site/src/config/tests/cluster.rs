//! Tests of `[cluster]`: servers, credentials and TLS.

use super::*;

/// Errors of a `[cluster]` with the required keys and `keys`.
fn refused(keys: &str) -> String {
    let text = format!("{BASE}[cluster]\nnode = \"one\"\nregion = \"north\"\n{keys}\n");
    parse(&text).map(|_| ()).map_or_else(|errors| errors.to_string(), |()| String::new())
}

#[test]
fn secret_in_server_address_is_refused_and_not_repeated() {
    for servers in [
        "[\"tls://user:hush@10.0.0.1:4222\"]",
        "[\"nats://hush@10.0.0.1\", \"nats://10.0.0.2\"]",
        "[\"tls://user:hu/hush@10.0.0.1\"]",
        // Errors of another cause must not repeat the secret either.
        "[\"http://user:hush@10.0.0.1\"]",
        "[\"user:hush@10.0.0.1\"]",
        "\"tls://user:hush@10.0.0.1:4222\"",
        "[[\"tls://user:hush@10.0.0.1\"]]",
    ] {
        let errors = refused(&format!("servers = {servers}"));
        assert!(errors.contains("cluster.servers") && !errors.contains("hush"), "{servers}\n{errors}");
    }
    let errors = refused("servers = [\"tls://user:hush@10.0.0.1:4222\"]");
    assert!(errors.contains("credentials = …") && errors.contains("nkey = …"), "{errors}");
}

#[test]
fn seed_instead_of_its_file_is_refused_and_not_repeated() {
    let seed = format!("SU{}", "A2".repeat(28));
    let errors = refused(&format!("servers = [\"nats://10.0.0.1\"]\nnkey = \"{seed}\""));
    assert!(errors.contains("cluster.nkey: this is a seed itself") && !errors.contains(&seed), "{errors}");
}

#[test]
fn proofs_that_contradict_each_other_are_refused() {
    for (keys, wanted) in [
        ("certificate = \"a\"", "certificate and key belong together"),
        ("key = \"a\"", "certificate and key belong together"),
        ("credentials = \"a\"\nnkey = \"b\"", "give one of the two"),
        ("inbox = \"_INBOX.>\"", "words of letters"),
        ("inbox = \"a..b\"", "words of letters"),
    ] {
        let errors = refused(&format!("servers = [\"nats://10.0.0.1\"]\n{keys}"));
        assert!(errors.contains(wanted), "{keys}\n{errors}");
    }
}

#[test]
fn answers_come_to_subjects_of_the_role() {
    let inbox = |keys: &str| {
        let servers = "servers = [\"nats://10.0.0.1\"]";
        let text = format!("{BASE}[cluster]\nnode = \"one\"\nregion = \"north\"\n{servers}\n{keys}\n");
        parse(&text).unwrap().cluster.unwrap().inbox()
    };
    assert_eq!(inbox(""), "_INBOX");
    assert_eq!(inbox("roles = [\"gateway\"]"), "_INBOX.gateway");
    assert_eq!(inbox("roles = [\"picture\"]\ninbox = \"_INBOX.operator\""), "_INBOX.operator");
}
