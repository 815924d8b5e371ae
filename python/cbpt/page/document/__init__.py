"""The document that the page shows, part by part; `document` puts it together."""
