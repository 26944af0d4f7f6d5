//! Writes the lines of a layer with indentation, and numbers with the fewest digits that read back exactly.

use std::fmt::Write;

use glam::DMat4;

#[derive(Default)]
pub(super) struct Text {
    text: String,
    depth: usize,
}

impl Text {
    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.text.into_bytes()
    }

    pub(super) fn line(&mut self, line: &str) {
        if !line.is_empty() {
            self.indent();
            self.text.push_str(line);
        }
        self.text.push('\n');
    }

    /// Appends to the last line.
    pub(super) fn continue_line(&mut self, more: &str) {
        self.text.pop();
        self.text.push_str(more);
        self.text.push('\n');
    }

    fn indent(&mut self) {
        self.text.extend(std::iter::repeat_n("    ", self.depth));
    }

    /// Begins a prim, with its metadata.
    pub(super) fn open(&mut self, kind: &str, name: &str, metadata: &[&str]) {
        self.line(&format!("{kind} \"{name}\""));
        if !metadata.is_empty() {
            self.continue_line(" (");
            self.depth += 1;
            metadata.iter().for_each(|line| self.line(line));
            self.depth -= 1;
            self.line(")");
        }
        self.line("{");
        self.depth += 1;
    }

    /// Ends the last open prim.
    pub(super) fn close(&mut self) {
        self.depth -= 1;
        self.line("}");
    }

    /// Writes `name = [a, b, ...]`.
    pub(super) fn list<T>(&mut self, name: &str, items: impl IntoIterator<Item = T>, write: impl Fn(&mut String, T)) {
        self.indent();
        self.text.push_str(name);
        self.text.push_str(" = ");
        self.items(items, &write);
        self.text.push('\n');
    }

    fn items<T>(&mut self, items: impl IntoIterator<Item = T>, write: &impl Fn(&mut String, T)) {
        self.text.push('[');
        for (index, item) in items.into_iter().enumerate() {
            if index > 0 {
                self.text.push_str(", ");
            }
            write(&mut self.text, item);
        }
        self.text.push(']');
    }

    /// Writes `name.timeSamples = { time: [a, b, ...], ... }`. If there is a single time, writes one value without a
    /// time.
    pub(super) fn samples<T>(
        &mut self,
        name: &str,
        times: &[f64],
        at: impl Fn(usize) -> Vec<T>,
        write: impl Fn(&mut String, T),
    ) {
        if times.len() < 2 {
            return self.list(name, at(0), write);
        }
        self.line(&format!("{name}.timeSamples = {{"));
        self.depth += 1;
        for (index, time) in times.iter().enumerate() {
            self.indent();
            let _ = write!(self.text, "{time}: ");
            self.items(at(index), &write);
            self.text.push_str(",\n");
        }
        self.depth -= 1;
        self.line("}");
    }
}

/// Writes `(a, b, c)`. Writing to a string cannot fail.
pub(super) fn tuple<const N: usize>(out: &mut String, numbers: [f32; N]) {
    for (index, number) in numbers.into_iter().enumerate() {
        let separator = if index == 0 { "(" } else { ", " };
        // Turns -0 into 0.
        let _ = write!(out, "{separator}{}", number + 0.0);
    }
    out.push(')');
}

/// Writes a matrix in USD's order: a column of `matrix` is a row in the file.
pub(super) fn matrix(out: &mut String, matrix: DMat4) {
    let rows = matrix.to_cols_array_2d().map(|row| {
        let numbers = row.map(|number| (number + 0.0).to_string());
        format!("({})", numbers.join(", "))
    });
    let _ = write!(out, "( {} )", rows.join(", "));
}

/// A string in quotes.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            c if c.is_ascii_control() => {
                let _ = write!(out, "\\x{:02x}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// Writes `displayName = "..."` if an identifier differs from the scene's name.
pub(super) fn display_name(name: &str, identifier: &str) -> Option<String> {
    (name != identifier).then(|| format!("displayName = {}", quoted(name)))
}
