//! Updates one section of the document and leaves the others unchanged.

use clap::ValueEnum;

/// A section that is independent of the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DocumentSection {
    /// The limit.
    Limit,
    /// A wider world.
    Worlds,
}

impl DocumentSection {
    /// Heading of the section after it.
    const fn next(self) -> &'static str {
        match self {
            Self::Limit => "## What the numbers mean",
            Self::Worlds => "## Real flights",
        }
    }

    /// Returns the document with this text as the section; `None` if the heading of the next section is missing.
    pub fn put_into(self, document: &str, text: &str) -> Option<String> {
        let heading = text.lines().next()?;
        let at = |heading: &str| document.find(&format!("\n{heading}\n")).map(|before| before + 1);
        let next = at(self.next())?;
        let begins = at(heading).filter(|&begins| begins < next).unwrap_or(next);
        Some(format!("{}{}\n\n{}", &document[..begins], text.trim_end(), &document[next..]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn section_is_put_before_its_next_and_replaced_there() {
        let document = "# A\n\n## B\nold\n\n## Real flights\nc\n";
        let first = DocumentSection::Worlds.put_into(document, "## A wider world\n\n1\n").unwrap();
        assert_eq!(first, "# A\n\n## B\nold\n\n## A wider world\n\n1\n\n## Real flights\nc\n");
        let second = DocumentSection::Worlds.put_into(&first, "## A wider world\n\n2\n").unwrap();
        assert_eq!(second, first.replace("1\n", "2\n"));
        assert_eq!(DocumentSection::Limit.put_into(document, "## The limit\n"), None);
    }
}
