//! Receivers of a configuration: opened, described, tested and started.

use std::sync::Arc;

use axum::http::HeaderValue;
use tokio::sync::watch;
use tokio::task::JoinHandle;

use super::Notices;
use super::delivery::NoticeQueue;
use super::mirror::Mirror;
use super::mqtt::Broker;
use super::outbox::NoticeOutbox;
use super::selection::NoticeSelection;
use super::signature::SigningSecret;
use super::webhook::Webhook;
use crate::net::dial::{Certificates, Dialer};
use crate::net::mqtt::Login;
use crate::net::peers::{Deliveries, UnusableReceiver, is_local};
use crate::net::secret::secret;
use site::config::{self, AlertKind, Config, Severity};

/// Receivers of alerts, before any connection is made.
#[derive(Debug, Default)]
pub struct NoticeReceivers {
    webhooks: Vec<Webhook>,
    broker: Option<Broker>,
    /// Descriptions for the log and the terminal.
    lines: Vec<String>,
    warnings: Vec<String>,
}

impl NoticeReceivers {
    /// Opens the receivers of a configuration; reads their secrets.
    ///
    /// # Errors
    /// A secret or a certificate cannot be read or used.
    pub fn open(config: &Config) -> Result<Self, UnusableReceiver> {
        let mut receivers = Self::default();
        for webhook in &config.alerts.webhooks {
            let refuse =
                |problem| UnusableReceiver::new(format!("alerts.webhooks, id \"{}\"", webhook.id), problem);
            receivers.lines.push(webhook_line(webhook));
            receivers.warnings.extend(webhook_warning(webhook));
            let text =
                secret(webhook.secret_file.as_deref(), webhook.secret_env.as_deref()).map_err(refuse)?;
            receivers.warnings.extend(text.and_then(|text| secret_warning(webhook, &text)));
            receivers.webhooks.push(Webhook::open(webhook, &config.site.name).map_err(refuse)?);
        }
        if let Some(mqtt) = &config.alerts.mqtt {
            receivers.lines.push(mqtt_line(mqtt));
            receivers.warnings.extend(mqtt_warning(mqtt));
            let refuse = |problem| UnusableReceiver::new("alerts.mqtt".to_owned(), problem);
            receivers.broker = Some(Broker::open(mqtt, &config.site).map_err(refuse)?);
        }
        Ok(receivers)
    }

    /// One description for each receiver, without secrets.
    pub fn lines(&self) -> &[String] {
        &self.lines
    }

    /// Weaknesses of the configuration that the operator should remove.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Sends each receiver a test. Returns its name with its answer, or the error.
    pub async fn test(&self) -> Vec<(String, Result<String, String>)> {
        let mut answers = Vec::new();
        for webhook in &self.webhooks {
            answers.push((webhook.queue.name().to_owned(), webhook.test().await));
        }
        if let Some(broker) = &self.broker {
            answers.push((broker.queue.name().to_owned(), broker.test().await));
        }
        answers
    }

    /// Begins to deliver; called within a runtime.
    pub fn start(self) -> (Notices, Deliveries) {
        let Self { webhooks, broker, .. } = self;
        let queues =
            webhooks.iter().map(|webhook| &webhook.queue).chain(broker.iter().map(|broker| &broker.queue));
        let notices = Notices(queues.cloned().collect());
        let closing = watch::Sender::new(false);
        let mut tasks: Vec<JoinHandle<()>> = Vec::new();
        for webhook in webhooks {
            tasks.push(tokio::spawn(webhook.deliver(closing.subscribe())));
        }
        if let Some(broker) = broker {
            tasks.push(tokio::spawn(broker.deliver(closing.subscribe())));
        }
        (notices, Deliveries::new(closing, tasks))
    }
}

impl Webhook {
    fn open(webhook: &config::Webhook, site: &str) -> Result<Self, String> {
        let config::Webhook { id, url, secret_file, secret_env, authorization_file, ca, timeout_s, .. } =
            webhook;
        let host = url.host().unwrap_or_default();
        let dial = if webhook.is_tls() {
            Dialer::tls(
                host,
                url.port_u16().unwrap_or(443),
                &Certificates { ca: ca.as_deref(), ..Certificates::default() },
            )?
        } else {
            Dialer::plain(host, url.port_u16().unwrap_or(80))
        };
        let key = secret(secret_file.as_deref(), secret_env.as_deref())?;
        let key = key.map(|text| SigningSecret::new(&text)).transpose()?;
        let authorization = match secret(authorization_file.as_deref(), None)? {
            None => None,
            Some(text) => {
                let value = HeaderValue::from_str(&text);
                let mut value =
                    value.map_err(|_| "authorization_file holds what no header can".to_owned())?;
                value.set_sensitive(true);
                Some(value)
            }
        };
        let name = format!("webhook:{id}");
        let selection = NoticeSelection::new(name.clone(), webhook.kinds.clone(), webhook.min_severity);
        Ok(Self {
            queue: Arc::new(NoticeQueue::new(name, NoticeOutbox::new(selection, None))),
            url: url.clone(),
            dial,
            secret: key,
            authorization,
            timeout: timeout_s.unsigned_abs(),
            site: site.to_owned(),
            run: run()?,
        })
    }
}

impl Broker {
    fn open(mqtt: &config::Mqtt, site: &config::Site) -> Result<Self, String> {
        let config::Mqtt { host, port, ca, username, password_file, password_env, .. } = mqtt;
        let dial = if mqtt.tls {
            Dialer::tls(host, *port, &Certificates { ca: ca.as_deref(), ..Certificates::default() })?
        } else {
            Dialer::plain(host, *port)
        };
        let password = secret(password_file.as_deref(), password_env.as_deref())?.unwrap_or_default();
        let name = "mqtt".to_owned();
        let selection = NoticeSelection::new(name.clone(), mqtt.kinds.clone(), mqtt.min_severity);
        Ok(Self {
            queue: Arc::new(NoticeQueue::new(name, NoticeOutbox::new(selection, Some(Mirror::default())))),
            dial,
            client_id: client_id(mqtt, site),
            login: username.clone().map(|username| Login { username, password }),
            prefix: mqtt.prefix.clone(),
            site: site.name.clone(),
            run: run()?,
        })
    }
}

fn client_id(mqtt: &config::Mqtt, site: &config::Site) -> String {
    mqtt.client_id.clone().unwrap_or_else(|| format!("utm-fusion-{}-{}", site.sac, site.sic))
}

/// Random id of this run.
fn run() -> Result<String, String> {
    let number = getrandom::u64().map_err(|error| format!("the system gives no random numbers: {error}"))?;
    Ok(format!("{number:016x}"))
}

fn webhook_line(webhook: &config::Webhook) -> String {
    let config::Webhook { id, url, kinds, min_severity, .. } = webhook;
    // The path may be a secret.
    let origin = format!(
        "{}://{}/…",
        url.scheme_str().unwrap_or_default(),
        url.authority().map_or("", |authority| authority.as_str())
    );
    let is_signed = webhook.secret_file.is_some() || webhook.secret_env.is_some();
    let signed = if is_signed { "signed" } else { "not signed" };
    format!("alerts to webhook:{id}: {origin}, {signed}, {}", wanted(kinds.as_deref(), *min_severity))
}

fn mqtt_line(mqtt: &config::Mqtt) -> String {
    let config::Mqtt { host, port, tls, username, prefix, kinds, min_severity, .. } = mqtt;
    let tls = if *tls { "TLS" } else { "without TLS" };
    let who = username.as_ref().map_or("without a user".to_owned(), |username| format!("as {username}"));
    let wanted = wanted(kinds.as_deref(), *min_severity);
    format!("alerts to mqtt: {host}:{port}, {tls}, {who}, topics {prefix}/…, {wanted}")
}

fn webhook_warning(webhook: &config::Webhook) -> Option<String> {
    let is_open = webhook.authorization_file.is_some() && !webhook.is_tls();
    (is_open && !is_local(webhook.url.host().unwrap_or_default()))
        .then(|| format!("webhook:{}: its authorization travels beyond this machine without TLS", webhook.id))
}

fn secret_warning(webhook: &config::Webhook, secret: &str) -> Option<String> {
    (!SigningSecret::is_standard(secret)).then(|| {
        format!(
            "webhook:{}: its secret does not begin with whsec_, so the libraries of Standard Webhooks do not verify what it \
             signs; echo \"whsec_$(openssl rand -base64 32)\" makes one",
            webhook.id
        )
    })
}

fn mqtt_warning(mqtt: &config::Mqtt) -> Option<String> {
    let is_open = (mqtt.password_file.is_some() || mqtt.password_env.is_some()) && !mqtt.tls;
    (is_open && !is_local(&mqtt.host))
        .then(|| "mqtt: its password travels beyond this machine without TLS".to_owned())
}

fn wanted(kinds: Option<&[AlertKind]>, min_severity: Severity) -> String {
    let kinds = kinds.map_or("all kinds".to_owned(), |kinds| {
        kinds.iter().map(AlertKind::name).collect::<Vec<_>>().join(", ")
    });
    match min_severity {
        Severity::Warning => kinds,
        Severity::Critical => format!("{kinds}, critical only"),
    }
}
