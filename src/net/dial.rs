//! Connections to receivers: TCP, with TLS where it is wanted.

use std::fmt;
use std::io;
use std::path::Path;
use std::sync::Arc;

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

/// Either kind of connection.
pub(crate) trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<S: AsyncRead + AsyncWrite + Send + Unpin> Stream for S {}

/// What both sides prove to each other.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Proofs<'a> {
    /// The certificates that the receiver's has to be issued by; `None`: those that this machine trusts.
    pub(crate) ca: Option<&'a Path>,
    /// The name that the receiver's certificate has to have; `None`: that of its host.
    pub(crate) server_name: Option<&'a str>,
    /// Own certificate and key, PEM, for receivers that ask for them.
    pub(crate) own: Option<(&'a Path, &'a Path)>,
}

/// Where a receiver is.
#[derive(Clone)]
pub(crate) struct Dial {
    host: String,
    port: u16,
    tls: Option<(TlsConnector, ServerName<'static>)>,
}

impl fmt::Debug for Dial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Dial").field("host", &self.host).field("port", &self.port).finish_non_exhaustive()
    }
}

impl Dial {
    /// Without TLS.
    pub(crate) fn plain(host: &str, port: u16) -> Self {
        Self { host: host.trim_matches(['[', ']']).to_owned(), port, tls: None }
    }

    /// With TLS.
    pub(crate) fn tls(host: &str, port: u16, proofs: &Proofs<'_>) -> Result<Self, String> {
        let plain = Self::plain(host, port);
        let roots = match proofs.ca {
            Some(file) => from_file(file)?,
            None => trusted()?,
        };
        let config = client_config(roots, proofs.own)?;
        let name = proofs.server_name.unwrap_or(&plain.host);
        let name = ServerName::try_from(name.to_owned())
            .map_err(|_| format!("{name} is no name that a certificate can have"))?;
        Ok(Self { tls: Some((Arc::new(config).into(), name)), ..plain })
    }

    /// Connects.
    pub(crate) async fn dial(&self) -> io::Result<Box<dyn Stream>> {
        let stream = TcpStream::connect((&*self.host, self.port)).await?;
        stream.set_nodelay(true)?;
        Ok(match &self.tls {
            None => Box::new(stream),
            Some((connector, name)) => Box::new(connector.connect(name.clone(), stream).await?),
        })
    }
}

impl Proofs<'_> {
    /// Whether the files can be read, are what they should be, and key and certificate belong together.
    #[cfg(feature = "cluster")]
    pub(crate) fn check(&self) -> Result<(), String> {
        let roots = self.ca.map_or_else(|| Ok(RootCertStore::empty()), from_file)?;
        client_config(roots, self.own).map(drop)
    }
}

fn client_config(roots: RootCertStore, own: Option<(&Path, &Path)>) -> Result<ClientConfig, String> {
    let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .map_err(|error| error.to_string())?
        .with_root_certificates(roots);
    let Some((certificate, key)) = own else { return Ok(config.with_no_client_auth()) };
    config
        .with_client_auth_cert(certificates(certificate)?, private_key(key)?)
        .map_err(|error| format!("{}: cannot be used with {}: {error}", certificate.display(), key.display()))
}

fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, String> {
    let certificates: Vec<_> = CertificateDer::pem_file_iter(file)
        .and_then(Iterator::collect)
        .map_err(|error| format!("{}: cannot be read as certificates in PEM: {error}", file.display()))?;
    if certificates.is_empty() {
        return Err(format!("{}: holds no certificate", file.display()));
    }
    Ok(certificates)
}

fn private_key(file: &Path) -> Result<PrivateKeyDer<'static>, String> {
    PrivateKeyDer::from_pem_file(file)
        .map_err(|error| format!("{}: cannot be read as a private key in PEM: {error}", file.display()))
}

fn from_file(file: &Path) -> Result<RootCertStore, String> {
    let mut roots = RootCertStore::empty();
    for certificate in certificates(file)? {
        let added = roots.add(certificate);
        added.map_err(|error| format!("{}: a certificate cannot be used: {error}", file.display()))?;
    }
    Ok(roots)
}

/// Those of the system, or of the variable `SSL_CERT_FILE`.
fn trusted() -> Result<RootCertStore, String> {
    const NONE: &str = "this machine trusts no certificates that are known; install them (Debian: ca-certificates), or name \
                        those of the receiver with ca = …";
    let file = openssl_probe::probe().cert_file.ok_or(NONE)?;
    let certificates = CertificateDer::pem_file_iter(&file)
        .map_err(|error| format!("{}: cannot be read: {error}", file.display()))?;
    let mut roots = RootCertStore::empty();
    // Some of the system's are too old for it.
    let (added, _) = roots.add_parsable_certificates(certificates.flatten());
    if added == 0 { Err(NONE.to_owned()) } else { Ok(roots) }
}
