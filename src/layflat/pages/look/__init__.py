"""The look that all pages share: theme and charts."""
