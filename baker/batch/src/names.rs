//! Names of assets in the output folder: filled from a template, and fit for every system's files.

/// The longest part of a name, bytes: file systems allow 255, endings take the rest.
const MAX_PART: usize = 200;

/// Folders in which a batch keeps what isn't an asset to be used.
const RESERVED: [&str; 2] = ["rejected", "reports"];

/// What may stand in braces.
const PLACEHOLDERS: [&str; 5] = ["path", "stem", "extension", "parent", "map"];

/// What a template is filled with.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// The mesh's path, normal.
    pub path: &'a str,
    /// How it begins, and what the name leaves out of it.
    pub fixed_part: &'a str,
    /// Name of the folder in which it lies.
    pub parent: &'a str,
}

/// A template's texts and placeholders in turns: text, placeholder, text, ..., text.
///
/// # Errors
/// In words, for braces that hold nothing known.
fn pieces(template: &str) -> Result<Vec<&str>, String> {
    let mut out = Vec::new();
    let mut rest = template;
    while let Some((text, behind)) = rest.split_once('{') {
        let known = format!("known are {{{}}}", PLACEHOLDERS.join("}, {"));
        let (name, after) = behind.split_once('}').ok_or_else(|| format!("a `{{` has no end; {known}"))?;
        if !PLACEHOLDERS.contains(&name) {
            return Err(format!("`{{{name}}}` stands for nothing; {known}"));
        }
        out.extend([text, name]);
        rest = after;
    }
    out.push(rest);
    Ok(out)
}

/// Whether a template can be filled.
///
/// # Errors
/// In words.
pub fn check_template(template: &str) -> Result<(), String> {
    let pieces = pieces(template)?;
    // Whatever is filled in, the texts between must be fit.
    let filled: String =
        pieces.iter().enumerate().map(|(i, piece)| if i % 2 == 0 { piece } else { "x" }).collect();
    check(&filled)
}

/// The name of an asset, not checked.
///
/// # Errors
/// In words, if the template can't be filled.
pub fn fill(template: &str, mesh: &Mesh, map: Option<&str>) -> Result<String, String> {
    let below = mesh.path.strip_prefix(mesh.fixed_part).unwrap_or(mesh.path);
    let file = mesh.path.rsplit('/').next().unwrap_or_default();
    let value = |name: &str| match name {
        "path" => without_extension(below),
        "stem" => without_extension(file),
        "extension" => file.strip_prefix(without_extension(file)).unwrap_or_default().trim_start_matches('.'),
        "parent" => mesh.parent,
        _ => map.unwrap_or_default(),
    };
    let pieces = pieces(template)?;
    let behind = map.filter(|_| !pieces.iter().skip(1).step_by(2).any(|name| *name == "map"));
    let filled = pieces.iter().enumerate().map(|(i, piece)| if i % 2 == 0 { piece } else { value(piece) });
    Ok(filled.collect::<String>() + &behind.map_or(String::new(), |map| format!(".{map}")))
}

/// A path without its file's last extension.
fn without_extension(path: &str) -> &str {
    let file = path.rfind('/').map_or(0, |slash| slash + 1);
    match path.rfind('.') {
        Some(dot) if dot > file => &path[..dot],
        _ => path,
    }
}

/// Whether a name is a path below a folder that every system takes.
///
/// # Errors
/// In words.
pub fn check(name: &str) -> Result<(), String> {
    match name {
        "" => Err("the name is empty".into()),
        _ if name.starts_with('/') => {
            Err(format!("`{name}` is an absolute path; names are below the output folder"))
        }
        _ if RESERVED
            .iter()
            .any(|part| name.split('/').next().is_some_and(|first| first.eq_ignore_ascii_case(part))) =>
        {
            Err(format!(
                "`{name}` begins with a folder of the batch's own ({}); name it otherwise",
                RESERVED.join(", ")
            ))
        }
        _ => name.split('/').try_for_each(check_part).map_err(|reason| match name.contains('/') {
            true => format!("`{name}`: {reason}"),
            false => reason,
        }),
    }
}

/// Whether a part of a name can be a file's on every system.
///
/// # Errors
/// In words.
pub fn check_part(part: &str) -> Result<(), String> {
    let reason = if part.is_empty() {
        return Err("a part of the name is empty".into());
    } else if part == "." || part == ".." {
        "goes out of its folder"
    } else if part.chars().any(|c| c.is_control() || r#"<>:"/\|?*"#.contains(c)) {
        r#"has a character that files can't have everywhere: < > : " / \ | ? * or a control character"#
    } else if part.ends_with(['.', ' ']) {
        "ends in a dot or a space, which Windows leaves out"
    } else if is_device(part) {
        "is the name of a device on Windows"
    } else if part.len() > MAX_PART {
        "is longer than 200 bytes"
    } else {
        return Ok(());
    };
    Err(format!("`{}` {reason}", part.escape_debug()))
}

fn is_device(part: &str) -> bool {
    let stem = part.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let numbered = |digits: &str| matches!(digits.as_bytes(), [b'1'..=b'9']);
    matches!(stem.as_str(), "CON" | "PRN" | "AUX" | "NUL")
        || stem.strip_prefix("COM").or(stem.strip_prefix("LPT")).is_some_and(numbered)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn templates_are_filled() {
        let mesh = Mesh { path: "m/props/duck.v2.obj", fixed_part: "m/", parent: "props" };
        let name = |template, map| fill(template, &mesh, map).unwrap();
        assert_eq!(name("{path}", None), "props/duck.v2");
        assert_eq!(name("{path}", Some("near")), "props/duck.v2.near");
        assert_eq!(name("{map}/{parent}_{stem}", Some("near")), "near/props_duck.v2");
        assert_eq!(name("fixed", None), "fixed");
        assert_eq!(without_extension("a.b/.hidden"), "a.b/.hidden");
        for bad in ["{size}", "{path", "{}", "/{path}", "../{path}", "{path}//{stem}", "a:{stem}", ""] {
            assert!(check_template(bad).is_err(), "{bad}");
        }
        assert!(check_template("{parent}/{stem}.{map}").is_ok());
    }

    #[test]
    fn names_are_fit_for_every_system() {
        for good in ["a", "a/b.c", ".a", "console", "com10", "a b", "größe", "LPT"] {
            assert_eq!(check(good), Ok(()), "{good}");
        }
        let long = "x".repeat(201);
        for bad in
            ["", "/a", "a//b", "a/", "..", "a/../b", "a\\b", "a\n", "a.", "a ", "nul", "x/COM1.h5", &long]
        {
            assert!(check(bad).is_err(), "{bad}");
        }
    }
}
