//! Secrets, read from files or environment variables, never from the configuration.

use std::env;
use std::path::Path;

/// Secret from a file or an environment variable, if one is named.
pub fn secret(file: Option<&Path>, variable: Option<&str>) -> Result<Option<String>, String> {
    let (place, text) = match (file, variable) {
        (Some(file), _) => {
            #[expect(clippy::disallowed_methods, reason = "the one place that reads receivers' secrets")]
            let text = std::fs::read_to_string(file);
            let place = file.display().to_string();
            let text = text.map_err(|error| format!("{place}: cannot be read: {error}"))?;
            (place, text)
        }
        (None, Some(variable)) => {
            let text = env::var(variable).map_err(|_| format!("the variable {variable} is not set"))?;
            (format!("the variable {variable}"), text)
        }
        (None, None) => return Ok(None),
    };
    let text = text.trim();
    if text.is_empty() {
        return Err(format!("{place} is empty"));
    }
    Ok(Some(text.to_owned()))
}
