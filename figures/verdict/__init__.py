"""All methods side by side: errors, laws and costs."""
