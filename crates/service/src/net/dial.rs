//! TCP connections to receivers, with TLS if configured.

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

/// A TCP or TLS connection.
pub(crate) trait ByteStream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<S: AsyncRead + AsyncWrite + Send + Unpin> ByteStream for S {}

/// Certificates for the authentication of both sides.
#[derive(Clone, Copy, Debug, Default)]
pub struct Certificates<'a> {
    /// Certificates of the authority that issued the receiver's; `None`: those that this machine trusts.
    pub ca: Option<&'a Path>,
    /// Name in the receiver's certificate; `None`: that of its host.
    pub server_name: Option<&'a str>,
    /// Own certificate and key, PEM, for receivers that require them.
    pub own: Option<(&'a Path, &'a Path)>,
}

/// Address of a receiver, with its TLS settings.
#[derive(Clone)]
pub(crate) struct Dialer {
    host: String,
    port: u16,
    tls: Option<(TlsConnector, ServerName<'static>)>,
}

impl fmt::Debug for Dialer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Dial").field("host", &self.host).field("port", &self.port).finish_non_exhaustive()
    }
}

impl Dialer {
    /// Address without TLS.
    pub fn plain(host: &str, port: u16) -> Self {
        Self { host: host.trim_matches(['[', ']']).to_owned(), port, tls: None }
    }

    /// Address with TLS.
    pub fn tls(host: &str, port: u16, proofs: &Certificates<'_>) -> Result<Self, String> {
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
    pub async fn dial(&self) -> io::Result<Box<dyn ByteStream>> {
        let stream = TcpStream::connect((&*self.host, self.port)).await?;
        stream.set_nodelay(true)?;
        Ok(match &self.tls {
            None => Box::new(stream),
            Some((connector, name)) => Box::new(connector.connect(name.clone(), stream).await?),
        })
    }
}

impl Certificates<'_> {
    /// Checks that the files can be read and have the right content, and that key and certificate belong together.
    pub fn check(&self) -> Result<(), String> {
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

/// Trusted certificates of the system, or of the file in `SSL_CERT_FILE`.
fn trusted() -> Result<RootCertStore, String> {
    const NONE: &str = "this machine trusts no certificates that are known; install them (Debian: ca-certificates), or name \
                        those of the receiver with ca = …";
    let file = openssl_probe::probe().cert_file.ok_or(NONE)?;
    let certificates = CertificateDer::pem_file_iter(&file)
        .map_err(|error| format!("{}: cannot be read: {error}", file.display()))?;
    let mut roots = RootCertStore::empty();
    // Some certificates of the system may be too old to be parsed.
    let (added, _) = roots.add_parsable_certificates(certificates.flatten());
    if added == 0 { Err(NONE.to_owned()) } else { Ok(roots) }
}
