//! What the XML formats share.

use quick_xml::XmlVersion;
use quick_xml::events::BytesStart;

/// The value of an attribute, by its name without a prefix.
pub fn attribute(tag: &BytesStart, name: &str) -> Option<String> {
    let found = tag.attributes().flatten().find(|a| a.key.local_name().as_ref() == name)?;
    Some(found.normalized_value(XmlVersion::default()).ok()?.into_owned())
}

/// The line of a byte offset.
pub fn line_of(bytes: &[u8], offset: usize) -> String {
    let before = &bytes[..offset.min(bytes.len())];
    format!("line {}", 1 + before.iter().filter(|&&b| b == b'\n').count())
}
