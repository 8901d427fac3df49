//! Webhooks: posted notices, also with failing receivers.

use std::net::TcpListener;

use rcgen::{CertificateParams, KeyPair};
use sha2::{Digest, Sha256};
use utm_fusion::live::{Alert, AlertChange, Severity};
use utm_fusion::notices::{NoticeLoss, NoticeReceivers};

use super::receiver::{Receiver, Say, over_tls};
use super::{Desk, alert, ended, site, wait_for};
use crate::common::{Scratch, utm_fusion};

const SECRET: &[u8] = b"0123456789abcdef0123456789abcdef";

fn hook(id: &str, url: &str, more: &str) -> String {
    format!("[[alerts.webhooks]]\nid = \"{id}\"\nurl = \"{url}\"\n{more}\n")
}

/// HMAC by its definition in RFC 2104: H(key ^ outer, H(key ^ inner, text)).
fn hmac(key: &[u8], text: &[u8]) -> Vec<u8> {
    let mut block = [0; 64];
    block[..key.len()].copy_from_slice(key);
    let padded = |pad: u8| block.map(|octet| octet ^ pad);
    let inner = Sha256::new().chain_update(padded(0x36)).chain_update(text).finalize();
    Sha256::new().chain_update(padded(0x5c)).chain_update(inner).finalize().to_vec()
}

#[test]
fn notice_is_signed_and_retried_until_accepted() {
    let scratch = Scratch::new();
    let secret = scratch.file("secret", "whsec_MDEyMzQ1Njc4OWFiY2RlZjAxMjM0NTY3ODlhYmNkZWY=\n");
    let authorization = scratch.file("authorization", "Bearer opensesame\n");
    let receiver = Receiver::start(&[Say::Status(500, ""), Say::Status(500, "")]);
    let more = format!(
        "secret_file = \"{}\"\nauthorization_file = \"{}\"",
        secret.display(),
        authorization.display()
    );
    let mut desk = Desk::open(&site(&hook("a", &receiver.url(), &more)));
    desk.note(AlertChange::Began, &alert(1));
    let posted = [receiver.next(), receiver.next(), receiver.next()];
    for post in &posted {
        assert_eq!(post.path, "/hook?key=1");
        let header = |name: &str| post.headers[name].clone();
        assert_eq!(header("host"), format!("127.0.0.1:{}", receiver.port));
        assert_eq!(header("content-type"), "application/json");
        assert_eq!(header("authorization"), "Bearer opensesame");
        // The same content is the same notice.
        assert_eq!(post.headers["webhook-id"], posted[0].headers["webhook-id"]);
        assert_eq!(post.body, posted[0].body);
        assert_eq!(post.json()["id"], header("webhook-id"));
        let signed =
            [header("webhook-id").as_bytes(), b".", header("webhook-timestamp").as_bytes(), b".", &post.body]
                .concat();
        let encoded = header("webhook-signature").strip_prefix("v1,").unwrap().to_owned();
        use base64::Engine;
        let signature = base64::engine::general_purpose::STANDARD.decode(encoded).unwrap();
        assert_eq!(signature, hmac(SECRET, &signed));
    }
    let json = posted[2].json();
    assert_eq!((&json["site"], &json["change"]), (&"north".into(), &"began".into()));
    assert_eq!(json["alert"]["text"], "T-1 is inside Airfield");
    wait_for("it is taken", || desk.counts("webhook:a").sent == 1);
    let counts = desk.counts("webhook:a");
    assert_eq!((counts.failed, counts.waiting, counts.is_failing), (2, 0, false));
    // A later notice of the same alert has another id.
    desk.note(AlertChange::Ended, &ended(1));
    let end = receiver.next();
    assert_ne!(end.headers["webhook-id"], posted[0].headers["webhook-id"]);
    assert_eq!(end.json()["alert"]["until"], "2025-11-13T02:13:29.000Z");
}

#[test]
fn rejected_notice_is_lost_and_the_next_is_sent() {
    let answers = [
        Say::Status(429, "Retry-After: 1\r\n"),
        Say::Status(404, ""),
        Say::Status(307, "Location: /elsewhere\r\n"),
    ];
    let receiver = Receiver::start(&answers);
    let mut desk = Desk::open(&site(&hook("a", &receiver.url(), "")));
    desk.note(AlertChange::Began, &alert(1));
    desk.note(AlertChange::Began, &alert(2));
    desk.note(AlertChange::Began, &alert(3));
    let mut told: Vec<_> = (0..4).map(|_| receiver.next()).collect();
    assert!(!told[0].headers.contains_key("webhook-signature"), "there is no secret");
    // The first is to be repeated later, and waits behind the others, which are rejected.
    let ids = |post: &super::receiver::Posted| (post.told().0, post.path.clone());
    let first = told.remove(0);
    assert_eq!(ids(&first), ("area-1".to_owned(), "/hook?key=1".to_owned()));
    let wanted = ["area-2", "area-3", "area-1"].map(|id| (id.to_owned(), "/hook?key=1".to_owned()));
    assert_eq!(told.iter().map(ids).collect::<Vec<_>>(), wanted);
    wait_for("the first is taken", || desk.counts("webhook:a").sent == 1);
    assert!(receiver.is_done());
    assert_eq!(NoticeLoss::ALL.map(|loss| desk.counts("webhook:a").lost(loss)), [0, 2, 0]);
    assert_eq!(desk.troubles(), [""; 0], "it works again");
}

#[test]
fn rejection_is_a_fault_until_a_delivery_succeeds() {
    let receiver = Receiver::start(&[Say::Status(401, "")]);
    let mut desk = Desk::open(&site(&hook("a", &receiver.url(), "")));
    desk.note(AlertChange::Began, &alert(1));
    wait_for("it is refused", || desk.counts("webhook:a").lost(NoticeLoss::Refused) == 1);
    let wanted = "webhook:a: one notice of an alert is lost: answered 401 Unauthorized";
    assert_eq!(desk.troubles(), [wanted]);
    desk.note(AlertChange::Began, &alert(2));
    wait_for("the next is taken", || desk.troubles().is_empty());
}

#[test]
fn slow_receiver_delays_no_other_and_gets_the_newest() {
    let (slow, quick) = (Receiver::start(&[Say::Nothing]), Receiver::start(&[]));
    let hooks = hook("slow", &slow.url(), "timeout_s = 0.5") + &hook("quick", &quick.url(), "");
    let mut desk = Desk::open(&site(&hooks));
    desk.note(AlertChange::Began, &alert(1));
    assert_eq!(slow.next().told(), ("area-1".to_owned(), "began".to_owned(), vec![]));
    // A waiting notice is replaced by a newer one, also at the quick receiver.
    wait_for("the quick one has the first", || desk.counts("webhook:quick").sent == 1);
    for count in 2..=20 {
        desk.note(AlertChange::Changed, &Alert { severity: Severity::Critical, ..alert(1) });
        wait_for("the quick one has it", || desk.counts("webhook:quick").sent == count);
    }
    let began = vec!["began".to_owned()];
    assert_eq!(slow.next().told(), ("area-1".to_owned(), "changed".to_owned(), began));
    wait_for("the slow one has it", || desk.counts("webhook:slow").sent == 1);
    assert!(slow.is_done());
}

#[test]
fn returning_receiver_gets_the_present_alerts() {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let mut desk = Desk::open(&site(&hook("a", &format!("http://127.0.0.1:{port}"), "")));
    desk.note(AlertChange::Began, &alert(1));
    wait_for("it fails", || desk.counts("webhook:a").failed >= 1);
    desk.note(AlertChange::Acknowledged, &alert(1));
    desk.note(AlertChange::Ended, &ended(1));
    let receiver = Receiver::on(TcpListener::bind(("127.0.0.1", port)).unwrap(), &[]);
    let earlier = ["began", "acknowledged"].map(str::to_owned).to_vec();
    let posted = receiver.next();
    assert_eq!(posted.path, "/");
    assert_eq!(posted.told(), ("area-1".to_owned(), "ended".to_owned(), earlier));
    desk.close();
    assert!(receiver.is_done());
}

#[test]
fn critical_alert_overtakes_a_flood_at_a_slow_webhook() {
    let (receiver, answer) = Receiver::held();
    let mut desk = Desk::open(&site(&hook("a", &receiver.url(), "")));
    desk.note(AlertChange::Began, &alert(1));
    assert_eq!(receiver.next().told().0, "area-1");
    // The first notice is not answered yet.
    (2..=500).for_each(|id| desk.note(AlertChange::Began, &alert(id)));
    desk.note(AlertChange::Began, &Alert { severity: Severity::Critical, ..alert(501) });
    answer.send(()).unwrap();
    assert_eq!(receiver.next().told().0, "area-501", "it is the next call");
    answer.send(()).unwrap();
    let notice = receiver.next().json();
    let summary = &notice["summary"];
    assert_eq!((&notice["change"], &summary["count"]), (&"summary".into(), &499.into()));
    assert_eq!((&summary["kind"], &summary["effect"]), (&"area".into(), &"began".into()));
    answer.send(()).unwrap();
    wait_for("all are sent", || desk.counts("webhook:a").sent == 501);
    assert_eq!(NoticeLoss::ALL.map(|loss| desk.counts("webhook:a").lost(loss)), [0; 3]);
    assert!(receiver.is_done());
}

#[test]
fn waiting_notices_are_sent_when_the_service_ends() {
    let receiver = Receiver::start(&[]);
    let mut desk = Desk::open(&site(&hook("a", &receiver.url(), "")));
    (1..=5).for_each(|id| desk.note(AlertChange::Began, &alert(id)));
    desk.close();
    assert_eq!(desk.counts("webhook:a").sent, 5);
}

#[test]
fn tls_receiver_needs_a_valid_certificate() {
    let scratch = Scratch::new();
    let key = KeyPair::generate().unwrap();
    let certificate =
        CertificateParams::new(vec!["localhost".to_owned()]).unwrap().self_signed(&key).unwrap();
    let ca = scratch.file("ca.pem", certificate.pem());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("https://localhost:{}/", listener.local_addr().unwrap().port());
    let heard = over_tls(listener, &certificate.pem(), &key.serialize_pem());
    let other = CertificateParams::new(vec!["localhost".to_owned()]).unwrap();
    let other = scratch.file("other.pem", other.self_signed(&KeyPair::generate().unwrap()).unwrap().pem());
    let hooks = hook("known", &url, &format!("ca = \"{}\"", ca.display()))
        + &hook("unknown", &url, &format!("ca = \"{}\"", other.display()));
    let receivers = NoticeReceivers::open(&site(&hooks)).unwrap();
    let answers = utm_fusion::app::runtime(1).unwrap().block_on(receivers.test());
    assert_eq!(answers[0], ("webhook:known".to_owned(), Ok("answered 200 OK".to_owned())));
    let why = answers[1].1.clone().unwrap_err();
    assert!(why.contains("invalid peer certificate"), "{why}");
    assert_eq!(heard.try_iter().count(), 1);
}

#[test]
fn unusable_receiver_is_rejected_by_key() {
    let scratch = Scratch::new();
    let short = scratch.file("short", "short\n");
    for (more, told) in [
        ("secret_env = \"UTM_FUSION_NO_SUCH_SECRET\"", "the variable UTM_FUSION_NO_SUCH_SECRET is not set"),
        ("secret_file = \"/no/such/file\"", "/no/such/file: cannot be read"),
        (&format!("secret_file = \"{}\"", short.display()), "the secret is shorter than 16 octets"),
        ("authorization_file = \"/dev/null\"", "/dev/null is empty"),
    ] {
        let refused =
            NoticeReceivers::open(&site(&hook("a", "http://127.0.0.1:1/", more))).unwrap_err().to_string();
        assert!(refused.starts_with("alerts.webhooks, id \"a\": ") && refused.contains(told), "{refused}");
    }
    let ca = format!("ca = \"{}\"", short.display());
    let refused =
        NoticeReceivers::open(&site(&hook("a", "https://127.0.0.1:1/", &ca))).unwrap_err().to_string();
    assert!(refused.contains("holds no certificate"), "{refused}");
}

#[test]
fn unencrypted_receiver_is_warned_of() {
    let scratch = Scratch::new();
    let file = scratch.file("authorization", "Bearer opensesame");
    let warned = |url: &str| {
        let hook = hook("a", url, &format!("authorization_file = \"{}\"", file.display()));
        !NoticeReceivers::open(&site(&hook)).unwrap().warnings().is_empty()
    };
    assert!(warned("http://192.0.2.1/"));
    assert!(!warned("https://192.0.2.1/") && !warned("http://[::1]/") && !warned("http://localhost/"));
    let mqtt = |host: &str| {
        let text = format!(
            "[alerts.mqtt]\nhost = \"{host}\"\nusername = \"fusion\"\npassword_file = \"{}\"",
            file.display()
        );
        NoticeReceivers::open(&site(&text)).unwrap().warnings().to_vec()
    };
    assert_eq!(mqtt("192.0.2.1"), ["mqtt: its password travels beyond this machine without TLS"]);
    assert_eq!(mqtt("127.0.0.1"), [""; 0]);
}

#[test]
fn check_names_receivers_without_their_secrets_and_tries_them() {
    let scratch = Scratch::new();
    let secret = scratch.file("secret", "0123456789abcdef0123456789abcdef");
    let receiver = Receiver::start(&[]);
    let hooks = hook("good", &receiver.url(), &format!("secret_file = \"{}\"", secret.display()))
        + &hook("bad", "http://127.0.0.1:1/", "kinds = [\"area\"]\nmin_severity = \"critical\"");
    let file = scratch.file("site.toml", site(&hooks).to_string());
    let check = |notify: &[&str]| {
        let output = utm_fusion("check").arg(&file).args(notify).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (code, told) = check(&[]);
    assert_eq!(code, Some(0));
    let good = format!("# alerts to webhook:good: http://127.0.0.1:{}/…, signed, all kinds\n", receiver.port);
    let bad = "# alerts to webhook:bad: http://127.0.0.1:1/…, not signed, area, critical only\n";
    assert!(told.contains(&good) && told.contains(bad) && !told.contains("0123456789abcdef"), "{told}");
    let (code, told) = check(&["--notify"]);
    assert_eq!(code, Some(1), "{told}");
    assert!(told.contains("webhook:good: ok, answered 204"), "{told}");
    assert!(told.contains("webhook:bad: FAILED: ") && told.contains("refused"), "{told}");
    let test = receiver.next().json();
    assert_eq!((&test["change"], &test["alert"]["part"]), (&"test".into(), &"test".into()));
    assert_eq!(test["alert"]["since"], test["alert"]["until"], "nobody waits for its end");
}
