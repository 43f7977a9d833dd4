"""What the site of docs/ needs beside Sphinx's own extensions: equations, the reference, and a look at its links."""
