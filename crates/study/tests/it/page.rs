//! The page of a report as tests read it.

use std::path::Path;

/// The page with the data of its figures unpacked.
pub(crate) fn read(path: &Path) -> String {
    let page = std::fs::read_to_string(path).unwrap();
    let packed = page.split_once("id=\"pictures\">").unwrap().1.split_once("</script>").unwrap().0;
    let pictures = luenberger_figures::unpacked(&page, "pictures").unwrap();
    page.replace(packed, &String::from_utf8(pictures).unwrap())
}

/// The visible text of a page.
pub(crate) fn body(page: &str) -> String {
    let body = page.split_once("<body>").unwrap().1;
    let parts = body.split("<script");
    parts.enumerate().map(|(k, part)| if k == 0 { part } else { part.split_once("</script>").unwrap().1 }).collect()
}
